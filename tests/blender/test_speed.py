# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.squash_from_speed: the speed sampled in the world, kept as keys, driving Squash."""

import math

import bpy
import numpy as np
import pytest
import scenes
from test_drivers import (
    all_are_simple,
    all_drivers,
    ball_that_carries_its_lattice,
    evaluated_input,
    ground_object,
    lowest,
    refused,
    select,
)


def key_places(obj: bpy.types.Object, path: str, values: list[float], axis: int) -> None:
    """Keys one coordinate at every frame from 1 on."""
    for frame, value in enumerate(values, start=1):
        obj.location[axis] = value
        obj.keyframe_insert(path, index=axis, frame=frame)


def falling_ball(**options) -> tuple[bpy.types.Object, bpy.types.NodesModifier, np.ndarray]:
    """A ball that falls freely through frames 1 to 20, and its height at each."""
    ball, modifier = ball_that_carries_its_lattice(**options)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, 20, 25
    times = np.arange(20) / 25.0
    heights = 20.0 - 9.81 / 2.0 * times**2
    key_places(ball, "location", list(heights), 2)
    select(ball)
    return ball, modifier, heights


def speed_at(obj: bpy.types.Object, frame: int) -> float:
    bpy.context.scene.frame_set(frame)
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())["isochor_speed"]


def test_the_speed_of_a_fall_is_kept_as_keys_and_stretches_with_constant_volume():
    ball, modifier, _heights = falling_ball()
    bpy.context.scene.frame_set(7, subframe=0.25)
    assert bpy.ops.isochor.squash_from_speed(stretch=1.6) == {"FINISHED"}
    assert (bpy.context.scene.frame_current, bpy.context.scene.frame_subframe) == (7, 0.25)
    assert all_are_simple()
    whole = scenes.volume(ball.data)
    fastest = max(speed_at(ball, frame) for frame in range(1, 21))
    # In the first and last frame the object rests on one side: the keys end there.
    for frame in range(2, 20):
        wanted = 9.81 * (frame - 1) / 25.0
        assert speed_at(ball, frame) == pytest.approx(wanted, rel=1e-3)
        squash = evaluated_input(ball, modifier, "Squash")
        assert squash == pytest.approx(1.0 + 0.6 * wanted / fastest, rel=1e-3)
        assert abs(scenes.evaluated_volume(ball) / whole - 1.0) <= 1e-6
        height = np.ptp(scenes.evaluated_positions(ball)[:, 2])
        assert height > np.ptp(scenes.positions(ball.data)[:, 2]) or squash < 1.01
    bpy.context.scene.frame_set(5, subframe=0.5)
    between = evaluated_input(ball, modifier, "Squash")
    assert between == pytest.approx(1.0 + 0.6 * 9.81 * 4.5 / 25.0 / fastest, rel=1e-3)


def test_the_world_s_speed_counts_with_parents_and_constraints():
    ball, _modifier = ball_that_carries_its_lattice()
    carrier = bpy.data.objects.new("Carrier", None)
    bpy.context.scene.collection.objects.link(carrier)
    ball.parent = carrier
    ball.location = (2.0, 0.0, 0.0)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps, scene.render.fps_base = 1, 10, 30, 1.5
    for frame in range(13):
        carrier.rotation_euler.z = 0.05 * frame
        carrier.keyframe_insert("rotation_euler", frame=frame)
    select(ball)
    assert bpy.ops.isochor.squash_from_speed(full_speed=4.0) == {"FINISHED"}
    for frame in (1, 5, 10):
        assert speed_at(ball, frame) == pytest.approx(2.0 * math.sin(0.05) * 20.0, rel=1e-4)


def test_along_the_axis_a_sideways_flight_does_not_count():
    ball, modifier, heights = falling_ball()
    key_places(ball, "location", list(heights), 0)
    for direction, share in (("ANY", math.sqrt(2.0)), ("AXIS", 1.0)):
        assert bpy.ops.isochor.squash_from_speed(direction=direction) == {"FINISHED"}
        assert speed_at(ball, 10) == pytest.approx(share * 9.81 * 9 / 25.0, rel=1e-3)
    scenes.set_input(modifier, "Axis", "Y")
    refused(bpy.ops.isochor.squash_from_speed, "“Ball” does not move", direction="AXIS")


def test_frames_given_are_those_sampled_and_running_again_leaves_no_old_keys():
    ball, modifier, _heights = falling_ball()
    drivers = scenes.part("tool.drivers")
    for start, end in ((1, 20), (5, 9)):
        assert bpy.ops.isochor.squash_from_speed(frame_start=start, frame_end=end) == {"FINISHED"}
        curve = drivers.keys_of(ball, '["isochor_speed"]')
        assert [point.co[0] for point in curve.keyframe_points] == list(range(start, end + 1))
    assert len(all_drivers()) == 1
    assert speed_at(ball, 7) == pytest.approx(9.81 * 6 / 25.0, rel=1e-3)
    bpy.context.scene.frame_set(9)
    assert evaluated_input(ball, modifier, "Squash") == pytest.approx(1.5, abs=1e-5)


def test_in_a_file_opened_again_with_auto_run_off(tmp_path):
    ball, _modifier, _heights = falling_ball()
    bpy.ops.isochor.squash_from_speed()
    bpy.context.scene.frame_set(12)
    shape = scenes.evaluated_positions(ball)
    place = str(tmp_path / "fast.blend")
    bpy.context.scene.frame_set(1)
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place, use_scripts=False)
    ball = bpy.data.objects["Ball"]
    bpy.context.scene.frame_set(12)
    assert all_are_simple()
    assert evaluated_input(ball, ball.modifiers[0], "Squash") > 1.1
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() < 2e-6


def test_ground_and_speed_share_the_squash_and_the_ground_wins():
    ball, modifier, _heights = falling_ball()
    ground = ground_object(0.0)
    bpy.context.scene.frame_set(1)
    for _time in range(2):
        select(ball)
        assert bpy.ops.isochor.squash_from_speed(stretch=1.4) == {"FINISHED"}
        select(ball, ground)
        assert bpy.ops.isochor.squash_from_ground() == {"FINISHED"}
    (curve,) = all_drivers()
    assert all_are_simple()
    assert sorted(variable.name for variable in curve.driver.variables) == ["ground", "height", "speed"]
    bpy.context.scene.frame_set(15)
    stretch = evaluated_input(ball, modifier, "Squash")
    assert 1.1 < stretch < 1.4
    for depth in (0.9, 0.6, 0.3):
        ground.location.z = ball.matrix_world.translation.z - depth
        bpy.context.view_layer.update()
        assert evaluated_input(ball, modifier, "Squash") < 1.0, "in contact it is pressed, however fast it is"
        assert lowest(ball) == pytest.approx(ground.location.z, abs=2e-3)


def test_one_undo_step():
    falling_ball()
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.isochor.squash_from_speed("EXEC_DEFAULT", True) == {"FINISHED"}
    assert "isochor_speed" in bpy.data.objects["Ball"]
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert "isochor_speed" not in ball
    assert all_drivers() == []
    bpy.ops.ed.redo()
    assert speed_at(bpy.data.objects["Ball"], 10) > 3.0


def test_several_objects_each_by_their_own_speed():
    first, _modifier, _heights = falling_ball()
    second, _modifier = ball_that_carries_its_lattice()
    key_places(second, "location", [0.1 * frame for frame in range(20)], 1)
    select(first, second)
    assert bpy.ops.isochor.squash_from_speed() == {"FINISHED"}
    assert speed_at(second, 10) == pytest.approx(2.5, rel=1e-4)
    assert speed_at(first, 10) == pytest.approx(9.81 * 9 / 25.0, rel=1e-3)


def test_refusals():
    ball, modifier = ball_that_carries_its_lattice()
    select(ball)
    squash = bpy.ops.isochor.squash_from_speed
    refused(squash, "“Ball” does not move in frames 1 to 250: animate its place first")
    assert "isochor_speed" not in ball
    refused(squash, r"The last frame \(3\) comes before the first \(8\)", frame_start=8, frame_end=3)
    ball["isochor_speed"] = 0.0
    ball.driver_add('["isochor_speed"]').driver.expression = "1.0"
    refused(squash, "The property isochor_speed of “Ball” has a driver")
    ball.driver_remove('["isochor_speed"]')
    ball.driver_add(scenes.part("tool.drivers").data_path(modifier, "Squash")).driver.expression = "frame"
    refused(squash, "Squash of “Ball” has a driver of yours already")


def test_keys_that_belong_to_another_file_are_refused(tmp_path):
    ball, _modifier, _heights = falling_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (there, here):
        here.actions = list(there.actions)
    (action,) = here.actions
    ball, _modifier = ball_that_carries_its_lattice()
    ball.animation_data_create().action = action
    if ball.animation_data.action_slot is None:
        ball.animation_data.action_slot = action.slots[0]
    bpy.context.view_layer.update()
    refused(bpy.ops.isochor.squash_from_speed, "The keys of “Ball” come from another file")
