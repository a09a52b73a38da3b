# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to shape keys: without the add-on every frame has the shape that was seen."""

import bpy
import elsewhere
import numpy as np
import pytest
import scenes

FRAMES = 6


def bouncing() -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A ball whose lattice, keyed over the frames, squashes and shears it."""
    ball = scenes.sphere(16, 10)
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.context.scene.frame_set(1)
    modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    scenes.choose(ball)
    return ball, modifier


def shapes(obj: bpy.types.Object) -> np.ndarray:
    """(frames, V, 3): what Blender draws of the object."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def bake(**settings) -> set:
    return bpy.ops.isochor.bake(format="SHAPE_KEYS", **settings)


def key_names(obj: bpy.types.Object) -> list[str]:
    keys = obj.data.shape_keys
    return [] if keys is None else [key.name for key in keys.key_blocks]


def refused(words: str) -> None:
    """Baking raises an error with these words and adds no key."""
    before = {obj.name: key_names(obj) for obj in bpy.data.objects if obj.type == "MESH"}
    with pytest.raises(RuntimeError, match=words):
        bake()
    assert before == {obj.name: key_names(obj) for obj in bpy.data.objects if obj.type == "MESH"}


def keyed_fat(obj: bpy.types.Object) -> None:
    """A shape key of the mesh's own, keyed."""
    obj.shape_key_add(name="Basis")
    fat = obj.shape_key_add(name="Fat", from_mix=False)
    for point in fat.points:
        point.co.x *= 1.3
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        fat.value = value
        fat.keyframe_insert("value", frame=frame)


def test_without_the_add_on_frames_are_the_same_and_between_them_it_goes_straight(tmp_path):
    ball, modifier = bouncing()
    before, whole = shapes(ball), scenes.volume(ball.data)
    own = scenes.positions(ball.data)
    assert np.ptp(before[2], axis=0)[2] < 0.8 * np.ptp(before[0], axis=0)[2]
    assert bake() == {"FINISHED"}
    assert not modifier.show_viewport
    assert not modifier.show_render
    assert len(key_names(ball)) == FRAMES + 1
    assert np.array_equal(scenes.positions(ball.data), own)
    times = [*map(float, range(1, FRAMES + 1)), 2.25, 0.0, FRAMES + 3.0]
    after = elsewhere.played(tmp_path, "Ball", times)
    assert np.abs(after[:FRAMES] - before).max() < 3e-7
    for shape in after[:FRAMES]:
        assert abs(elsewhere.volume(shape, ball) / whole - 1) <= 1e-6
    assert np.abs(after[FRAMES] - (0.75 * before[1] + 0.25 * before[2])).max() < 1e-6
    assert np.abs(after[FRAMES + 1] - before[0]).max() < 3e-7
    assert np.abs(after[FRAMES + 2] - before[-1]).max() < 3e-7


def test_keys_of_the_mesh_stay_and_keep_playing(tmp_path):
    ball, _modifier = bouncing()
    keyed_fat(ball)
    before = shapes(ball)
    assert bake() == {"FINISHED"}
    after = elsewhere.played(tmp_path, "Ball", list(map(float, range(1, FRAMES + 1))))
    assert np.abs(after - before).max() < 1e-6
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert key_names(ball) == ["Basis", "Fat"]
    assert np.abs(shapes(ball) - before).max() < 1e-6
    action = ball.data.shape_keys.animation_data.action
    curves = action.layers[0].strips[0].channelbags[0].fcurves
    assert [curve.data_path for curve in curves] == ['key_blocks["Fat"].value']


def test_two_in_a_row_with_a_subdivision_behind():
    ball, _modifier = bouncing()
    scenes.volume_lattice(ball, scenes.get_input(ball.modifiers[0], "Lattice"), Basis="B-Spline")
    ball.modifiers.new("Subdivision", "SUBSURF")
    scenes.choose(ball)
    before = shapes(ball)
    assert bake() == {"FINISHED"}
    assert [modifier.show_viewport for modifier in ball.modifiers] == [False, False, True]
    assert np.abs(shapes(ball) - before).max() < 1e-6


def test_baking_is_one_undo_step_and_freeing_leaves_nothing():
    ball, _modifier = bouncing()
    before, actions = shapes(ball), len(bpy.data.actions)
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.bake("EXEC_DEFAULT", True, format="SHAPE_KEYS")
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert key_names(ball) == []
    assert np.abs(shapes(ball) - before).max() < 1e-6
    bpy.ops.ed.redo()
    ball = bpy.data.objects["Ball"]
    assert len(key_names(ball)) == FRAMES + 1
    scenes.choose(ball)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert key_names(ball) == []
    assert len(bpy.data.actions) == actions
    assert ball.modifiers[0].show_viewport
    assert ball.modifiers[0].show_render
    assert np.abs(shapes(ball) - before).max() < 1e-6


def test_some_frames_of_several_objects():
    first, _modifier = bouncing()
    second = scenes.sphere(8, 6, name="Second")
    scenes.volume_lattice(second, scenes.get_input(first.modifiers[0], "Lattice"), Basis="B-Spline")
    before = shapes(first), shapes(second)
    first.select_set(True)
    second.select_set(True)
    assert bake(frame_start=2, frame_end=4) == {"FINISHED"}
    for obj, shape in zip((first, second), before, strict=True):
        assert len(key_names(obj)) == 4
        assert np.abs(shapes(obj)[1:4] - shape[1:4]).max() < 1e-6
        assert np.abs(shapes(obj)[0] - shape[1]).max() < 1e-6


def test_what_stands_in_the_way_is_refused():
    ball, _modifier = bouncing()
    cast = ball.modifiers.new("Cast", "CAST")
    ball.modifiers.move(1, 0)
    refused("Cast comes before Volume Lattice on “Ball”")
    ball.modifiers.remove(cast)
    twin = bpy.data.objects.new("Twin", ball.data)
    refused("Other objects use the mesh of “Ball” too")
    bpy.data.objects.remove(twin)
    ball.shape_key_add(name="Basis")
    ball.data.shape_keys.use_relative = False
    refused("are absolute")
    ball.data.shape_keys.use_relative = True
    ball.show_only_shape_key = True
    refused("turn Solo off")
    ball.show_only_shape_key = False
    assert bake() == {"FINISHED"}


def test_a_bake_that_is_broken_off_leaves_everything_as_it_was():
    ball, _modifier = bouncing()
    frames, bake_keys = scenes.part("tool.frames"), scenes.part("tool.bake_keys")
    bake = bake_keys.bake(bpy.context, frames.targets([ball]), 1, FRAMES)
    next(bake)
    next(bake)
    bake.close()
    assert key_names(ball) == []
    assert ball.modifiers[0].show_viewport


def test_applying_is_refused_while_a_bake_plays():
    bouncing()
    bake()
    with pytest.raises(RuntimeError, match="free the bake first"):
        bpy.ops.isochor.apply()
