# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing ball of blend_fixtures, at every frame, on the mesh that a render engine is handed.

The plain deformation is Blender's own Lattice modifier on the same lattice object: an implementation that shares
nothing with ours.
"""

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import scenes

ROOT = Path(__file__).resolve().parents[2]
FIXTURE = ROOT / "blend_fixtures" / "bouncing_ball.blend"
sys.path.insert(0, str(ROOT / "addon" / "demo"))

from measuring_engine import measure_animation  # noqa: E402

FRAMES = range(1, 49)
MARKED_LOSSES = {16: 0.28, 19: 0.51, 24: 0.64}


@pytest.fixture
def ball():
    bpy.ops.wm.open_mainfile(filepath=str(FIXTURE))
    return bpy.data.objects["Ball"]


@pytest.fixture
def ours(ball):
    return next(modifier for modifier in ball.modifiers if modifier.name == scenes.MODIFIER)


def swap_in_native_lattice(ball, ours):
    """Blender's Lattice modifier in our modifier's place, on the same lattice object; returns it."""
    native = scenes.native_lattice(ball, scenes.get_input(ours, "Lattice"))
    show(ours, False)
    return native


def show(modifier, visible):
    modifier.show_viewport = modifier.show_render = visible


def at_frame(frame):
    bpy.context.scene.frame_set(frame)
    return bpy.context.evaluated_depsgraph_get()


def test_fixture_is_what_it_should_be(ball, ours):
    scene = bpy.context.scene
    corners = np.diff([polygon.loop_start for polygon in ball.data.polygons])
    assert len(ball.data.vertices) >= 40_000
    assert (corners == 3).all()
    assert range(scene.frame_start, scene.frame_end + 1) == FRAMES
    markers = {marker.frame: marker.name for marker in scene.timeline_markers}
    assert markers == {frame: f"{100 * loss:.0f} %" for frame, loss in MARKED_LOSSES.items()}
    asked = {name: scenes.get_input(ours, name) for name in ("Preserve", "Method", "Basis")}
    assert asked == {"Preserve": 1.0, "Method": "Balanced", "Basis": "B-Spline"}
    assert tuple(scenes.get_input(ours, "Axes")) == (1.0, 1.0, 0.0)


def test_fixture_holds_the_modifier_that_the_extension_makes_now():
    """If this fails, make the fixture again: blend_fixtures/make_bouncing_ball.py, in bpy 4.5."""
    node_group, sockets = scenes.part("tool.node_group"), scenes.part("tool.sockets")
    fresh = node_group.ensure()
    made_now = (sockets.identifiers(fresh), fresh[node_group.VERSION_KEY])
    bpy.ops.wm.open_mainfile(filepath=str(FIXTURE))
    (kept,) = node_group.all_groups()
    assert (sockets.identifiers(kept), kept[node_group.VERSION_KEY]) == made_now


def test_rendered_volume_is_kept_and_round_at_every_frame(ball, ours):
    rest_volume = scenes.volume(ball.data)
    rest = np.ptp(scenes.positions(ball.data), axis=0)
    measured = measure_animation(bpy.context.scene, ball)
    assert sorted(measured) == list(FRAMES)
    for frame, found in measured.items():
        width, depth, _height = found.extents
        assert abs(found.volume - rest_volume) / rest_volume <= 1e-6, f"frame {frame}: {found}"
        assert abs(width / depth - 1) <= 0.01, f"frame {frame}: not round from above: {found}"
        assert found.lowest >= -1e-5, f"frame {frame}: the ball is {-found.lowest} below the ground"
    deepest = measured[24].extents
    assert deepest[2] < 0.4 * rest[2]
    assert min(deepest[:2]) > 1.5 * max(rest[:2])


def test_plain_lattice_loses_what_the_paper_says(ball, ours):
    rest_volume = scenes.volume(ball.data)
    swap_in_native_lattice(ball, ours)
    measured = measure_animation(bpy.context.scene, ball)
    for frame, loss in MARKED_LOSSES.items():
        assert 1 - measured[frame].volume / rest_volume == pytest.approx(loss, abs=0.02)


def test_without_preservation_every_vertex_is_where_blender_puts_it(ball, ours):
    scenes.set_input(ours, "Preserve", 0.0)
    native = swap_in_native_lattice(ball, ours)
    size = max(ball.dimensions)
    for frame in (1, 12, 14, *MARKED_LOSSES, 27, 35, 48):
        show(ours, False)
        show(native, True)
        plain = scenes.evaluated_positions(ball, at_frame(frame))
        show(ours, True)
        show(native, False)
        found = scenes.evaluated_positions(ball, at_frame(frame))
        assert np.abs(found - plain).max() <= 1e-6 * size, f"frame {frame}"


def test_no_control_point_leaves_its_height(ball, ours):
    for frame in FRAMES:
        at_frame(frame)
        report = scenes.report(ball, ours)
        assert report.problems == ()
        assert np.array_equal(report.result.control[..., 2], report.asked[..., 2]), f"frame {frame}"
        moved = np.abs(report.result.control[..., :2] - report.asked[..., :2]).max()
        assert moved > 0.1 or frame not in MARKED_LOSSES


def test_corrected_ball_keeps_the_heights_of_the_plain_one(ball, ours):
    native = swap_in_native_lattice(ball, ours)
    plain = {frame: scenes.evaluated_positions(ball, at_frame(frame)) for frame in MARKED_LOSSES}
    show(native, False)
    show(ours, True)
    for frame in MARKED_LOSSES:
        found = scenes.evaluated_positions(ball, at_frame(frame))
        assert np.abs(found[:, 2] - plain[frame][:, 2]).max() <= 2e-6
