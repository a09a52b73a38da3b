# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, saving, loading, copying, deleting: the deformation survives or goes as it should."""

import bpy
import lattice_oracle
import numpy as np
import scenes
from installed_extension import MODULE


def squashed_ball(name: str = "Ball"):
    ball = scenes.sphere(name=name)
    lattice = scenes.lattice_object(4, name=f"{name} Cage")
    modifier = scenes.volume_lattice(ball, lattice)
    squash(lattice)
    return ball, lattice, modifier


def squash(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def height(obj: bpy.types.Object) -> float:
    return float(np.ptp(scenes.evaluated_positions(obj)[:, 2]))


def keeps_volume(obj: bpy.types.Object) -> bool:
    return abs(scenes.evaluated_volume(obj) / scenes.volume(obj.data) - 1) <= 1e-6


def test_undo_and_redo():
    ball, lattice, _ = squashed_ball()
    first = height(ball)
    bpy.ops.ed.undo_push(message="squashed")
    squash(lattice, 0.5)
    second = height(ball)
    bpy.ops.ed.undo_push(message="squashed more")
    assert second < 0.8 * first
    bpy.ops.ed.undo()
    ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Cage"]
    bpy.context.view_layer.update()
    assert np.isclose(height(ball), first, atol=1e-6)
    assert keeps_volume(ball)
    bpy.ops.ed.redo()
    ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Cage"]
    bpy.context.view_layer.update()
    assert np.isclose(height(ball), second, atol=1e-6)
    squash(lattice, 2.0)
    assert np.isclose(height(ball), first, atol=1e-5)


def test_adding_and_removing_are_one_undo_step_each():
    scenes.sphere()
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.add("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert not ball.modifiers
    assert not bpy.data.lattices
    bpy.ops.ed.redo()
    ball = bpy.data.objects["Ball"]
    assert len(ball.modifiers) == 1
    squash(bpy.data.objects["Ball Lattice"])
    assert height(ball) < 1.6
    assert keeps_volume(ball)
    scenes.choose(ball)
    bpy.ops.ed.undo_push(message="squashed")
    bpy.ops.isochor.remove("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    bpy.context.view_layer.update()
    assert height(ball) < 1.6
    squash(bpy.data.objects["Ball Lattice"], 0.9)
    assert keeps_volume(ball)


def test_save_and_load(tmp_path):
    ball, _lattice, _ = squashed_ball()
    shape = scenes.evaluated_positions(ball)
    place = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    bpy.ops.wm.open_mainfile(filepath=place)
    ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Cage"]
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() < 1e-6
    squash(lattice, 0.8)
    assert height(ball) < 0.9 * np.ptp(shape[:, 2])
    assert keeps_volume(ball)
    bpy.context.scene.frame_set(5)
    assert keeps_volume(ball)


def test_nodes_of_an_older_version_are_laid_anew_and_the_inputs_keep_their_values(tmp_path):
    ball, _lattice, modifier = squashed_ball()
    given = {"Space": "Lattice", "Method": "Sweep", "Target": 1.25, "Axes": (1.0, 0.5, 0.0), "Preserve": 0.75}
    for name, value in given.items():
        scenes.set_input(modifier, name, value)
    group = modifier.node_group
    kinds = sorted(node.bl_idname for node in group.nodes)
    group["isochor_version"] = 0
    for node in [node for node in group.nodes if node.bl_idname == "GeometryNodeSwitch"]:
        group.nodes.remove(node)
    place = str(tmp_path / "older.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Cage"]
    modifier = ball.modifiers[0]
    group = modifier.node_group
    assert sorted(node.bl_idname for node in group.nodes) == kinds
    assert group["isochor_version"] == scenes.part("tool.node_group").VERSION
    for name, value in given.items():
        found = scenes.get_input(modifier, name)
        assert found == value or tuple(found) == value, name
    scenes.set_input(modifier, "Target", 1.0)
    scenes.set_input(modifier, "Preserve", 1.0)
    squash(lattice, 0.8)
    assert height(ball) < 1.6
    assert keeps_volume(ball)


def test_orphan_purge_spares_the_results():
    ball, lattice, _ = squashed_ball()
    bpy.ops.outliner.orphans_purge(do_local_ids=True, do_recursive=True)
    squash(lattice, 0.9)
    assert keeps_volume(ball)
    assert height(ball) < 1.25


def test_duplicate_has_a_life_of_its_own():
    ball, lattice, modifier = squashed_ball()
    twin = ball.copy()
    bpy.context.scene.collection.objects.link(twin)
    other = lattice.copy()
    other.data = lattice.data.copy()
    bpy.context.scene.collection.objects.link(other)
    scenes.set_input(twin.modifiers[0], "Lattice", other)
    bpy.context.view_layer.update()
    for name in ("Viewport Result", "Render Result"):
        mine, copied = scenes.get_input(modifier, name), scenes.get_input(twin.modifiers[0], name)
        assert mine != copied
        assert mine.data != copied.data
    squash(other, 1.8)
    assert height(twin) > 1.5 > height(ball)
    assert keeps_volume(ball)
    assert keeps_volume(twin)
    for frame in (2, 3):
        squash(lattice, 0.9)
        bpy.context.scene.frame_set(frame)
        assert height(twin) > 1.5 > height(ball)


def test_duplicate_operator_and_duplicated_modifier():
    ball, _lattice, _ = squashed_ball()
    scenes.choose(ball)
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    bpy.context.view_layer.update()
    assert twin != ball
    assert keeps_volume(twin)
    assert scenes.get_input(twin.modifiers[0], "Viewport Result") != scenes.get_input(
        ball.modifiers[0], "Viewport Result"
    )
    bpy.ops.object.modifier_copy(modifier=twin.modifiers[0].name)
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    results = {scenes.get_input(modifier, "Viewport Result").name for modifier in twin.modifiers}
    assert len(results) == 2
    assert keeps_volume(twin)
    assert height(twin) < 0.8 * height(ball)


def test_modifier_copied_to_another_mesh_keeps_that_mesh_s_volume():
    ball, lattice, modifier = squashed_ball()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.7)
    other = bpy.context.object
    new = other.modifiers.new("Volume Lattice", "NODES")
    new.node_group = modifier.node_group
    for name in ("Lattice", "Viewport Result", "Render Result", "Slot", "Preserve"):
        scenes.set_input(new, name, scenes.get_input(modifier, name))
    bpy.context.view_layer.update()
    squash(lattice, 0.9)
    assert height(other) < 1.1
    assert keeps_volume(other)
    assert keeps_volume(ball)


def test_two_objects_sharing_one_mesh():
    ball, lattice, _ = squashed_ball()
    twin = bpy.data.objects.new("Twin", ball.data)
    scenes.linked(twin)
    cage = scenes.lattice_object(4, name="Twin Cage")
    scenes.volume_lattice(twin, cage)
    squash(cage, 1.5)
    assert ball.data == twin.data
    assert keeps_volume(ball)
    assert keeps_volume(twin)
    assert height(ball) < 1.5
    assert height(twin) > 2.5
    squash(lattice, 0.9)
    bpy.context.scene.frame_set(7)
    assert keeps_volume(ball)
    assert keeps_volume(twin)


def test_deleting_the_lattice_shows_the_mesh_undeformed_and_says_what_to_do():
    ball, lattice, modifier = squashed_ball()
    bpy.data.objects.remove(lattice)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 1e-6
    assert scenes.report(ball, modifier).problems == (
        "No lattice: pick a Lattice object in the modifier's Lattice input.",
    )
    bpy.context.scene.frame_set(2)
    scenes.set_input(modifier, "Lattice", scenes.lattice_object(3))
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()


def test_without_the_add_on_the_last_shape_stays(tmp_path):
    ball, lattice, _ = squashed_ball()
    shape = scenes.evaluated_positions(ball)
    place = str(tmp_path / "frozen.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        assert not hasattr(bpy.types, "ISOCHOR_OT_add")
        squash(lattice, 0.5)
        assert np.array_equal(scenes.evaluated_positions(ball), shape)
        bpy.ops.wm.open_mainfile(filepath=place)
        ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Cage"]
        bpy.context.scene.frame_set(4)
        assert np.abs(scenes.evaluated_positions(ball) - shape).max() < 1e-6
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)
    squash(lattice, 0.7)
    assert keeps_volume(ball)
    assert height(ball) < 0.8 * np.ptp(shape[:, 2])


def test_enabling_and_disabling_leaves_no_handler_behind():
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        for event in ("frame_change_post", "depsgraph_update_post", "undo_post", "redo_post", "load_post", "save_pre"):
            found = [handler.__module__ for handler in getattr(bpy.app.handlers, event)]
            assert not [name for name in found if name.startswith(MODULE)], event
        assert not hasattr(bpy.types, "VIEW3D_PT_isochor")
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)
    ball, _lattice, _ = squashed_ball()
    assert keeps_volume(ball)


def test_applying_the_modifier_bakes_the_shape_into_the_mesh():
    ball, _lattice, modifier = squashed_ball()
    shape = scenes.evaluated_positions(ball)
    scenes.choose(ball)
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    assert np.array_equal(scenes.positions(ball.data), shape)


def test_renaming_everything_changes_nothing():
    ball, lattice, modifier = squashed_ball()
    ball.name, lattice.name, modifier.name = "Pumpkin", "Box", "Shaper"
    squash(lattice, 0.8)
    assert keeps_volume(ball)
    wanted = lattice_oracle.deformed(ball, lattice, scenes.positions(ball.data), "Bernstein")
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 2e-6


def test_linked_object_keeps_its_shape_and_its_override_follows_the_lattice(tmp_path):
    ball = scenes.sphere()
    lattice = scenes.squashing_lattice(ball, 6, frames=20)
    bpy.context.scene.frame_set(6)
    scenes.volume_lattice(ball, lattice, Basis="B-Spline", Reference="Incoming")
    saved = scenes.evaluated_positions(ball)
    whole = scenes.volume(ball.data)
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    linked = wanted.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    for frame in (1, 10):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(scenes.evaluated_positions(linked), saved)
    assert "make a library override" in scenes.report(linked, linked.modifiers[0]).problems[0]
    override = linked.override_create(remap_local_usages=True)
    heights = []
    for frame in (1, 6, 10):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(override) / whole - 1) <= 1e-6
        heights.append(height(override))
    assert heights[0] > 1.2 * heights[1] > 1.2 * heights[2]


def test_appended_object_brings_what_it_needs(tmp_path):
    squashed_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    scenes.sphere(name="Other")
    bpy.ops.isochor.add()
    with bpy.data.libraries.load(place, link=False) as (_found, wanted):
        wanted.objects = ["Ball"]
    ball = wanted.objects[0]
    bpy.context.scene.collection.objects.link(ball)
    bpy.context.view_layer.update()
    squash(bpy.data.objects["Ball Cage"], 0.8)
    assert keeps_volume(ball)
    assert height(ball) < 1.25
