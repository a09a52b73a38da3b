# SPDX-License-Identifier: GPL-3.0-or-later
"""Files saved before the inputs of the panel Animate were there get them, and lose nothing."""

from pathlib import Path

import bpy
import numpy as np
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
GIVEN = {"Preserve": 0.75, "Target": 1.25, "Space": "Lattice", "Method": "Sweep", "Outside": "Extend", "Invert": True}


def as_of_version_1(group: bpy.types.NodeTree) -> None:
    """Takes out of the group what version 2 of the add-on's inputs brought."""
    handlers = scenes.part("tool.handlers")
    handlers.unregister()
    counting = [node for node in group.nodes if node.type == "MENU_SWITCH"]
    for item in list(group.interface.items_tree):
        if item.item_type == "SOCKET" and item.name in ANIMATE:
            for node in counting:
                if node.inputs[0].is_linked and node.inputs[0].links[0].from_socket.name == item.name:
                    group.nodes.remove(node)
                    counting.remove(node)
                    break
            group.interface.remove(item)
    group.interface.remove(next(item for item in group.interface.items_tree if item.name == "Animate"))
    group["isochor_version"] = 1
    scenes.part("tool.sockets").forget(group)
    handlers.register()


def old_file(place: Path, name: str = "Ball") -> np.ndarray:
    """Saves a ball squashed by its lattice as version 1 would have; returns its shape."""
    ball = scenes.sphere(name=name)
    lattice = scenes.lattice_object(4, name="Cage")
    modifier = scenes.volume_lattice(ball, lattice)
    for key, value in GIVEN.items():
        scenes.set_input(modifier, key, value)
    ball.keyframe_insert(path_of(modifier, "Target"), frame=1)
    for point in lattice.data.points:
        point.co_deform.z *= 0.5
    bpy.context.view_layer.update()
    as_of_version_1(modifier.node_group)
    names = [item.name for item in modifier.node_group.interface.items_tree]
    assert not set(ANIMATE) & set(names)
    shape = scenes.evaluated_positions(ball)
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    scenes.empty_file()
    return shape


def path_of(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of an input from its object, for keys and drivers."""
    path = scenes.part("tool.sockets").data_path(modifier, name)
    return f'modifiers["{modifier.name}"]{path}' if path.startswith("[") else f'modifiers["{modifier.name}"].{path}'


def test_an_older_file_gets_the_new_inputs_with_their_defaults_and_keeps_the_rest(tmp_path):
    place = tmp_path / "older.blend"
    shape = old_file(place)
    bpy.ops.wm.open_mainfile(filepath=str(place))
    ball = bpy.data.objects["Ball"]
    modifier = ball.modifiers[0]
    for name, value in {**GIVEN, **ANIMATE}.items():
        found = scenes.get_input(modifier, name)
        assert found == value, name
    items = modifier.node_group.interface.items_tree
    assert [item.name for item in items if item.item_type == "PANEL"] == ["Volume", "Animate", "Interpolation"]
    assert modifier.node_group["isochor_version"] == scenes.part("tool.node_group").VERSION
    assert np.array_equal(scenes.evaluated_positions(ball), shape)
    scenes.set_input(modifier, "Twist", 1.0)
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() > 0.05
    bpy.context.scene.frame_set(2)
    assert scenes.get_input(modifier, "Target") == 1.25
    if bpy.app.version >= (5, 0, 0):
        for name in ANIMATE:
            identifier = scenes.part("tool.sockets").identifiers(modifier.node_group)[name]
            assert modifier.is_input_used(identifier), name
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    bpy.ops.wm.open_mainfile(filepath=str(place))
    assert scenes.get_input(bpy.data.objects["Ball"].modifiers[0], "Twist") == 1.0


def test_several_modifiers_and_a_second_user_of_the_group_all_get_the_defaults(tmp_path):
    place = tmp_path / "older.blend"
    old_file(place)
    bpy.ops.wm.open_mainfile(filepath=str(place), load_ui=False)
    ball = bpy.data.objects["Ball"]
    other = ball.copy()
    bpy.context.scene.collection.objects.link(other)
    as_of_version_1(ball.modifiers[0].node_group)
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    bpy.ops.wm.open_mainfile(filepath=str(place))
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.modifiers:
            assert {name: scenes.get_input(obj.modifiers[0], name) for name in ANIMATE} == ANIMATE, obj.name


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
        assert {name: scenes.get_input(obj.modifiers[0], name) for name in ANIMATE} == ANIMATE, obj.name
