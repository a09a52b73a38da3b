# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh follows the lattice, the sockets and time, in whichever way they change."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes


def expected(ball: bpy.types.Object, lattice: bpy.types.Object, basis: str = "Bernstein") -> np.ndarray:
    return lattice_oracle.deformed(ball, lattice, scenes.positions(ball.data), basis)


def follows(ball: bpy.types.Object, lattice: bpy.types.Object, basis: str = "Bernstein") -> bool:
    """Whether the mesh is deformed, and as numpy says."""
    found, wanted = scenes.evaluated_positions(ball), expected(ball, lattice, basis)
    return np.abs(found - wanted).max() < 2e-6 and np.abs(wanted - scenes.positions(ball.data)).max() > 0.01


def plain_scene(side: int = 4):
    ball, lattice = scenes.sphere(), scenes.lattice_object(side)
    return ball, lattice, scenes.volume_lattice(ball, lattice, Preserve=0.0)


def test_points_moved_by_hand():
    ball, lattice, _ = plain_scene()
    for shift in (0.1, 0.2, -0.5):
        lattice.data.points[21].co_deform.y += shift
        bpy.context.view_layer.update()
        assert follows(ball, lattice)


def test_points_moved_in_the_lattice_s_edit_mode():
    ball, lattice, _ = plain_scene()
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(1.0, 1.0, 0.5))
    bpy.context.view_layer.update()
    heights = scenes.evaluated_positions(ball)[:, 2]
    assert np.allclose(heights, 0.5 * scenes.positions(ball.data)[:, 2], atol=1e-5)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball)[:, 2], heights)


def test_shape_keys_of_the_lattice_on_frames_and_between():
    ball = scenes.sphere()
    lattice = scenes.squashing_lattice(ball, 6, frames=20)
    modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    whole = scenes.volume(ball.data)
    for frame, subframe in ((5, 0.0), (5, 0.5), (10, 0.25), (20, 0.0)):
        scenes.set_input(modifier, "Preserve", 0.0)
        bpy.context.scene.frame_set(frame, subframe=subframe)
        assert follows(ball, lattice, "B-Spline")
        scenes.set_input(modifier, "Preserve", 1.0)
        bpy.context.scene.frame_set(frame, subframe=subframe)
        assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6


def test_hook_on_the_lattice():
    ball, lattice, _ = plain_scene()
    handle = bpy.data.objects.new("Handle", None)
    bpy.context.scene.collection.objects.link(handle)
    hook = lattice.modifiers.new("Hook", "HOOK")
    hook.object = handle
    hook.vertex_indices_set(range(48, 64))
    bpy.context.view_layer.update()
    handle.location = (0.3, 0.2, 0.5)
    bpy.context.view_layer.update()
    assert follows(ball, lattice)
    handle.keyframe_insert("location", frame=1)
    handle.location.z = 1.0
    handle.keyframe_insert("location", frame=9)
    for frame in (1, 6, 9):
        bpy.context.scene.frame_set(frame)
        assert follows(ball, lattice)


def test_deformed_lattice_and_object_moving_through_each_other():
    ball, lattice, _ = plain_scene(6)
    for point in lattice.data.points:
        point.co_deform.x += 0.2 * point.co.z
    for frame, place in ((1, (0.0, 0.0, 0.0)), (10, (0.4, 0.1, -0.3))):
        lattice.location = place
        lattice.rotation_euler.z = place[0]
        lattice.keyframe_insert("location", frame=frame)
        lattice.keyframe_insert("rotation_euler", frame=frame)
    for frame in (1, 4, 10):
        bpy.context.scene.frame_set(frame)
        assert follows(ball, lattice)
    ball.location = (0.1, -0.2, 0.3)
    bpy.context.view_layer.update()
    assert follows(ball, lattice)


def test_object_and_lattice_that_move_together_are_not_embedded_anew():
    ball, lattice, modifier = plain_scene()
    lattice.parent = ball
    lattice.data.points[0].co_deform.x += 0.3
    for frame, place in ((1, (0.0, 0.0, 0.0)), (10, (3.0, -2.0, 5.0))):
        ball.location = place
        ball.rotation_euler = place
        ball.keyframe_insert("location", frame=frame)
        ball.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_set(1)
    solver = scenes.part("tool.state").recall(ball, modifier).solver
    bound = solver.bound_transform
    for frame in range(2, 11):
        bpy.context.scene.frame_set(frame)
        assert follows(ball, lattice)
    assert solver.bound_transform is bound


def test_a_frame_in_which_nothing_moves_computes_nothing():
    ball, lattice, modifier = plain_scene()
    lattice.data.points[0].co_deform.x += 0.3
    ball.location.x = 1.0
    ball.keyframe_insert("location", frame=1)
    bpy.context.scene.frame_set(1)
    memory = scenes.part("tool.state").recall(ball, modifier)
    written = memory.written
    bpy.context.scene.frame_set(2)
    bpy.context.scene.frame_set(3)
    assert memory.written is written


def test_keyed_input():
    ball, lattice, modifier = plain_scene()
    whole = scenes.volume(ball.data)
    for point in lattice.data.points:
        point.co_deform.z *= 0.5
    path = f'modifiers["{modifier.name}"].{scenes.part("tool.sockets").data_path(modifier, "Preserve")}'
    for frame, value in ((1, 0.0), (11, 1.0)):
        scenes.set_input(modifier, "Preserve", value)
        assert ball.keyframe_insert(path, frame=frame)
    for curve in curves_of(ball.animation_data.action):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    for frame, kept in ((1, 0.5), (6, 0.75), (11, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert scenes.evaluated_volume(ball) == pytest.approx(kept * whole, rel=1e-5)


def curves_of(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    if bpy.app.version < (5, 0, 0):
        return list(action.fcurves)
    return [
        curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves
    ]


def test_driven_input_without_leave_to_run_scripts():
    assert not bpy.context.preferences.filepaths.use_scripts_auto_execute
    ball, lattice, modifier = plain_scene()
    whole = scenes.volume(ball.data)
    for point in lattice.data.points:
        point.co_deform.z *= 0.5
    path = f'modifiers["{modifier.name}"].{scenes.part("tool.sockets").data_path(modifier, "Preserve")}'
    driver = ball.driver_add(path).driver
    driver.type = "SCRIPTED"
    driver.expression = "min(frame / 10, 1)"
    for frame, kept in ((5, 0.75), (10, 1.0), (12, 1.0)):
        bpy.context.scene.frame_set(frame)
        assert scenes.evaluated_volume(ball) == pytest.approx(kept * whole, rel=1e-5)


def test_editing_the_mesh():
    ball, lattice, _ = plain_scene()
    lattice.data.points[0].co_deform.x += 0.3
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="EDIT")
    lattice.data.points[0].co_deform.x += 0.1
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(3)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(0.8, 0.8, 0.8))
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert follows(ball, lattice)


def test_mesh_in_edit_mode_follows_its_lattice():
    ball, lattice, modifier = plain_scene()
    modifier.show_in_editmode = True
    bpy.ops.object.mode_set(mode="EDIT")
    lattice.data.points[0].co_deform.x += 0.5
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert follows(ball, lattice)


def test_modifier_switched_off_and_on():
    ball, lattice, modifier = plain_scene()
    modifier.show_viewport = False
    lattice.data.points[0].co_deform.x += 0.5
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball), scenes.positions(ball.data))
    modifier.show_viewport = True
    bpy.context.view_layer.update()
    assert follows(ball, lattice)


def test_sculpting_shows_in_the_deformed_mesh():
    ball, lattice, _ = plain_scene()
    lattice.data.points[0].co_deform.x += 0.5
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="SCULPT")
    ball.data.vertices[40].co.x += 0.2
    ball.update_tag()
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert follows(ball, lattice)
