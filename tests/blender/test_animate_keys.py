# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs of the panel Animate take keys, drivers and NLA strips, on frames, between them and in renders."""

import math

import bpy
import numpy as np
import pytest
import scenes
from test_render import MeasuringEngine, add_camera_and_light, noted  # noqa: F401


def path_of(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of an input from its object, for keys and drivers."""
    path = scenes.part("tool.sockets").data_path(modifier, name)
    return f'modifiers["{modifier.name}"]{path}' if path.startswith("[") else f'modifiers["{modifier.name}"].{path}'


def ball_and_modifier() -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    ball = scenes.sphere()
    bpy.ops.isochor.add(margin=0.0)
    modifier = ball.modifiers.active
    scenes.set_input(modifier, "Axes", (1.0, 1.0, 0.0))
    return ball, modifier


def squashed(shape: np.ndarray, ball: bpy.types.Object) -> float:
    """Height as a factor of the own mesh's."""
    return float(np.ptp(shape[:, 2]) / np.ptp(scenes.positions(ball.data)[:, 2]))


def rendered(noted: list) -> list[tuple[float, np.ndarray]]:  # noqa: F811
    """When, and what shape, each render of frames 1 to 11 saw; by a render engine of our own."""
    add_camera_and_light()
    scene = bpy.context.scene
    scene.render.engine = MeasuringEngine.bl_idname
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 11, 5
    bpy.ops.render.render(animation=True)
    return [(when, shape) for when, _count, _volume, shape in noted]


def key(ball: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str, *keys: tuple[int, object]) -> None:
    for frame, value in keys:
        scenes.set_input(modifier, name, value)
        assert ball.keyframe_insert(path_of(modifier, name), frame=frame)
    for layer in ball.animation_data.action.layers:
        for curve in layer.strips[0].channelbags[0].fcurves:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"


def test_keys_on_frames_between_them_and_in_renders(noted):  # noqa: F811
    ball, modifier = ball_and_modifier()
    key(ball, modifier, "Squash", (1, 1.0), (11, 0.4))
    bpy.context.scene.frame_set(6, subframe=0.5)
    assert squashed(scenes.evaluated_positions(ball), ball) == pytest.approx(1.0 - 0.6 * 0.55, abs=1e-5)
    found = rendered(noted)
    assert len(found) == 9
    for when, shape in found:
        wanted = max(0.4, 1.0 - 0.06 * (when - 1.0))
        assert squashed(shape, ball) == pytest.approx(wanted, abs=1e-5)
        assert abs(noted[0][2] / scenes.volume(ball.data) - 1.0) <= 1e-6


@pytest.mark.parametrize(("name", "value"), [("Taper", 0.5), ("Twist", 2.0), ("Bend", 1.0), ("Bend Direction", 2.0)])
def test_every_number_takes_keys(name, value):
    ball, modifier = ball_and_modifier()
    if name == "Bend Direction":
        scenes.set_input(modifier, "Bend", 1.0)
    key(ball, modifier, name, (1, 0.0), (11, value))
    shapes = []
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        shapes.append(scenes.evaluated_positions(ball))
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) <= 1e-6
    for one, other in ((0, 1), (1, 2), (0, 2)):
        assert np.abs(shapes[one] - shapes[other]).max() > 0.03


def test_the_menus_take_keys():
    ball, modifier = ball_and_modifier()
    scenes.set_input(modifier, "Squash", 0.5)
    key(ball, modifier, "Pivot", (1, "Bottom"), (5, "Top"))
    key(ball, modifier, "Axis", (1, "Z"), (9, "X"))
    lows, highs = [], []
    for frame in (2, 6, 10):
        bpy.context.scene.frame_set(frame)
        points = scenes.report(ball, modifier).asked
        lows.append(points.reshape(-1, 3).min(axis=0))
        highs.append(points.reshape(-1, 3).max(axis=0))
    sizes = np.array(highs) - np.array(lows)
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-5)
    assert sizes[2][0] == pytest.approx(sizes[0][0] / 2.0, rel=1e-5)
    assert sizes[2][2] == pytest.approx(sizes[0][2] * 2.0, rel=1e-5)
    assert lows[1][2] - lows[0][2] == pytest.approx(sizes[0][2], rel=1e-5)


def test_a_driver_in_viewport_and_render(noted):  # noqa: F811
    ball, modifier = ball_and_modifier()
    driver = ball.driver_add(path_of(modifier, "Squash")).driver
    driver.type, driver.expression = "SCRIPTED", "1.0 - 0.06 * (frame - 1)"
    assert driver.is_simple_expression
    bpy.context.scene.frame_set(4)
    assert squashed(scenes.evaluated_positions(ball), ball) == pytest.approx(1.0 - 0.06 * 3, abs=1e-5)
    for when, shape in rendered(noted):
        assert squashed(shape, ball) == pytest.approx(1.0 - 0.06 * (when - 1.0), abs=1e-5)


def action_of_one_value(ball, modifier, name: str, value: float) -> bpy.types.Action:
    ball.animation_data_create().action = None
    scenes.set_input(modifier, name, value)
    ball.keyframe_insert(path_of(modifier, name), frame=1)
    ball.keyframe_insert(path_of(modifier, name), frame=20)
    action = ball.animation_data.action
    ball.animation_data.action = None
    return action


@pytest.mark.parametrize(
    ("blend", "influence", "wanted"), [("REPLACE", 0.5, 0.65), ("ADD", 1.0, 1.3), ("REPLACE", 0.25, 0.725)]
)
def test_two_nla_strips_blend(noted, blend, influence, wanted):  # noqa: F811
    ball, modifier = ball_and_modifier()
    actions = [action_of_one_value(ball, modifier, "Squash", value) for value in (0.8, 0.5)]
    scenes.set_input(modifier, "Squash", 1.0)
    strips = []
    for action in actions:
        track = ball.animation_data.nla_tracks.new()
        strips.append(track.strips.new(action.name, 1, action))
    strips[1].blend_type = blend
    strips[1].blend_in = strips[1].blend_out = 0.0
    strips[1].use_animated_influence = True
    strips[1].influence = influence
    strips[1].keyframe_insert("influence", frame=1)
    bpy.context.scene.frame_set(5)
    assert squashed(scenes.evaluated_positions(ball), ball) == pytest.approx(wanted, abs=1e-5)
    for _when, shape in rendered(noted):
        assert squashed(shape, ball) == pytest.approx(wanted, abs=1e-5)
    for _, _, volume, _ in noted:
        assert abs(volume / scenes.volume(ball.data) - 1.0) <= 1e-6


def test_the_end_to_end_turn_of_the_mesh_is_the_twist():
    """What the animator sees of it: the mesh's own vertices at the ends of the lattice."""
    ends = [(x, y, z) for z in (-1.0, 1.0) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    sides = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    tower = scenes.mesh_object("Tower", ends, [(3, 2, 1, 0), (4, 5, 6, 7), *sides])
    bpy.ops.isochor.add(margin=0.0)
    scenes.set_input(tower.modifiers.active, "Preserve", 0.0)
    scenes.set_input(tower.modifiers.active, "Twist", math.radians(60.0))
    bpy.context.view_layer.update()
    found = scenes.evaluated_positions(tower)
    assert np.abs(found[:4] - ends[:4]).max() < 1e-5
    turned = [(math.cos(a + math.pi / 3), math.sin(a + math.pi / 3), 1.0) for a in np.arange(4) * math.pi / 2]
    assert np.abs(found[4:] - turned).max() < 1e-5
