# SPDX-License-Identifier: GPL-3.0-or-later
"""Files saved before some of the inputs were there get them, and lose nothing."""

from pathlib import Path

import bpy
import numpy as np
import pytest
import scenes

ANIMATE = {
    "Axis": "Z",
    "Squash": 1.0,
    "Taper": 0.0,
    "Twist": 0.0,
    "Bend": 0.0,
    "Bend Direction": 0.0,
    "Pivot": "Bottom",
}
LATER = {
    "Frame": None,
    "Cost": "Points",
    "Stiffness": "",
    "Where Lost": 0.0,
    "Islands": False,
    "Region": "",
    "Region Target": 1.0,
    "Close Holes": False,
    "Unfolded": False,
    "Pins": None,
    "Falloff": 0.0,
}
"""Inputs that came with version 3."""
BLENDING = {"Weights": "", "Heaviest": 10.0, "Joint": "Free"}
"""Inputs that came with version 4."""
NEWER = {1: {**ANIMATE, **LATER, **BLENDING}, 2: {**LATER, **BLENDING}, 3: BLENDING}
"""By the version of a file, the inputs that it lacks."""
NEW_ITEMS = {"Gradient": 3, "Nearest": 3, "Custom": 3, "Blender": 4}
"""Of menus, and the version that brought each."""
NEW_PANELS = {1: ("Pins", "Animate"), 2: ("Pins",), 3: ()}
"""By the version of a file, the panels that it lacks."""
PANELS = ["Volume", "Pins", "Animate", "Interpolation"]
GIVEN = {"Preserve": 0.75, "Target": 1.25, "Space": "Lattice", "Method": "Sweep", "Outside": "Extend", "Invert": True}


def as_of_version(group: bpy.types.NodeTree, version: int) -> None:
    """Takes out of the group what later versions of the add-on's inputs brought."""
    handlers = scenes.part("tool.handlers")
    handlers.unregister()
    newer = NEWER[version]
    for node in [node for node in group.nodes if node.type == "MENU_SWITCH"]:
        if node.inputs[0].links[0].from_socket.name in newer:
            group.nodes.remove(node)
            continue
        while NEW_ITEMS.get(node.enum_items[-1].name, 0) > version:
            node.enum_items.remove(node.enum_items[-1])
    for item in list(group.interface.items_tree):
        if item.item_type == "SOCKET" and item.name in newer:
            group.interface.remove(item)
    for item in list(group.interface.items_tree):
        if item.item_type == "PANEL" and item.name in NEW_PANELS[version]:
            group.interface.remove(item)
    group["isochor_version"] = version
    scenes.part("tool.sockets").forget(group)
    handlers.register()


def old_file(place: Path, name: str = "Ball", version: int = 1) -> np.ndarray:
    """Saves a ball squashed by its lattice as that version would have; returns its shape."""
    ball = scenes.sphere(name=name)
    lattice = scenes.lattice_object(4, name="Cage")
    modifier = scenes.volume_lattice(ball, lattice)
    for key, value in GIVEN.items():
        scenes.set_input(modifier, key, value)
    ball.keyframe_insert(path_of(modifier, "Target"), frame=1)
    for point in lattice.data.points:
        point.co_deform.z *= 0.5
    bpy.context.view_layer.update()
    as_of_version(modifier.node_group, version)
    names = [item.name for item in modifier.node_group.interface.items_tree]
    assert not set(NEWER[version]) & set(names)
    shape = scenes.evaluated_positions(ball)
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    scenes.empty_file()
    return shape


def path_of(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of an input from its object, for keys and drivers."""
    path = scenes.part("tool.sockets").data_path(modifier, name)
    return f'modifiers["{modifier.name}"]{path}' if path.startswith("[") else f'modifiers["{modifier.name}"].{path}'


@pytest.mark.parametrize("version", NEWER)
def test_an_older_file_gets_the_new_inputs_with_their_defaults_and_keeps_the_rest(tmp_path, version):
    place = tmp_path / "older.blend"
    shape = old_file(place, version=version)
    bpy.ops.wm.open_mainfile(filepath=str(place))
    ball = bpy.data.objects["Ball"]
    modifier = ball.modifiers[0]
    for name, value in {**GIVEN, **NEWER[1]}.items():
        found = scenes.get_input(modifier, name)
        assert found == value, name
    items = modifier.node_group.interface.items_tree
    assert [item.name for item in items if item.item_type == "PANEL"] == PANELS
    assert modifier.node_group["isochor_version"] == scenes.part("tool.node_group").VERSION
    assert np.array_equal(scenes.evaluated_positions(ball), shape)
    scenes.set_input(modifier, "Twist", 1.0)
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() > 0.05
    bpy.context.scene.frame_set(2)
    assert scenes.get_input(modifier, "Target") == 1.25
    if bpy.app.version >= (5, 0, 0):
        for name in NEWER[1]:
            identifier = scenes.part("tool.sockets").identifiers(modifier.node_group)[name]
            assert modifier.is_input_used(identifier), name
    for name, value in {"Method": "Nearest", "Space": "Custom", "Cost": "Bending", "Stiffness": "Stiff"}.items():
        scenes.set_input(modifier, name, value)
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    bpy.ops.wm.open_mainfile(filepath=str(place))
    modifier = bpy.data.objects["Ball"].modifiers[0]
    kept = {name: scenes.get_input(modifier, name) for name in ("Twist", "Method", "Space", "Cost", "Stiffness")}
    assert kept == {"Twist": 1.0, "Method": "Nearest", "Space": "Custom", "Cost": "Bending", "Stiffness": "Stiff"}


def test_several_modifiers_and_a_second_user_of_the_group_all_get_the_defaults(tmp_path):
    place = tmp_path / "older.blend"
    old_file(place)
    bpy.ops.wm.open_mainfile(filepath=str(place), load_ui=False)
    ball = bpy.data.objects["Ball"]
    other = ball.copy()
    bpy.context.scene.collection.objects.link(other)
    as_of_version(ball.modifiers[0].node_group, 1)
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    bpy.ops.wm.open_mainfile(filepath=str(place))
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.modifiers:
            assert {name: scenes.get_input(obj.modifiers[0], name) for name in NEWER[1]} == NEWER[1], obj.name


def test_a_group_linked_from_an_older_file_works_without_the_new_inputs(tmp_path):
    place = tmp_path / "older.blend"
    shape = old_file(place)
    with bpy.data.libraries.load(str(place), link=True) as (_there, here):
        here.objects = ["Ball"]
    ball = bpy.data.objects["Ball"]
    bpy.context.scene.collection.objects.link(ball)
    override = ball.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, do_fully_editable=True)
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(3)
    assert override.is_editable
    group = override.modifiers[0].node_group
    assert group.library is not None
    assert "Squash" not in [item.name for item in group.interface.items_tree]
    assert scenes.report(override, override.modifiers[0]).problems == ()
    assert np.abs(scenes.evaluated_positions(override) - shape).max() < 1e-5
    new = scenes.sphere(name="New")
    bpy.ops.isochor.add()
    scenes.set_input(new.modifiers[0], "Squash", 0.5)
    bpy.context.scene.frame_set(4)
    assert np.ptp(scenes.evaluated_positions(new)[:, 2]) < 1.6
    assert np.abs(scenes.evaluated_positions(override) - shape).max() < 1e-5


def test_an_appended_older_group_is_renewed_with_the_next_lattice_added(tmp_path):
    place = tmp_path / "older.blend"
    old_file(place)
    with bpy.data.libraries.load(str(place), link=False) as (_there, here):
        here.objects = ["Ball"]
    old = here.objects[0]
    bpy.context.scene.collection.objects.link(old)
    bpy.context.view_layer.update()
    scenes.sphere(name="New")
    bpy.ops.isochor.add()
    for obj in (old, bpy.data.objects["New"]):
        assert {name: scenes.get_input(obj.modifiers[0], name) for name in NEWER[1]} == NEWER[1], obj.name
