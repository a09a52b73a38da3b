# SPDX-License-Identifier: GPL-3.0-or-later
"""The preferences of precision and of frame memory: the same picture, closer or sooner."""

from collections.abc import Iterator
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import scenes
from drawn import Layout
from installed_extension import MODULE

FRAMES = 12


@pytest.fixture(autouse=True)
def preferences() -> Iterator[bpy.types.AddonPreferences]:
    found = bpy.context.preferences.addons[MODULE].preferences
    yield found
    found.precision, found.memory = "SINGLE", 256


@pytest.fixture
def solves(monkeypatch) -> list[float]:
    """Grows by one for each frame that is really computed."""
    done: list[float] = []
    solver = scenes.part("core.solver").Solver
    fresh = solver._fresh

    def counted(self, request):
        done.append(bpy.context.scene.frame_current)
        return fresh(self, request)

    monkeypatch.setattr(solver, "_fresh", counted)
    return done


def squashed_ball(**inputs) -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.NodesModifier]:
    ball = scenes.sphere()
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    return ball, lattice, scenes.volume_lattice(ball, lattice, Basis="B-Spline", **inputs)


def play(ball: bpy.types.Object) -> list[np.ndarray]:
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(ball))
    return found


def exact_frame(ball: bpy.types.Object, modifier: bpy.types.NodesModifier) -> np.ndarray:
    """The frame shown, computed by the native library in float64 throughout."""
    report = scenes.report(ball, modifier)
    points = scenes.positions(ball.data)
    ball.data.calc_loop_triangles()
    triangles = np.array([triangle.vertices for triangle in ball.data.loop_triangles])
    lattice = scenes.part("core.grid").build_lattice(report.grid)
    return lattice.bind(points, triangles, device="cpu").preserve(report.asked).vertices


def test_double_comes_closer_to_the_exact_place_and_keeps_the_volume(preferences):
    ball, _lattice, modifier = squashed_ball()
    bpy.context.scene.frame_set(6)
    apart = {}
    for precision in ("SINGLE", "DOUBLE", "SINGLE"):
        preferences.precision = precision
        bpy.context.view_layer.update()
        found = scenes.evaluated_positions(ball)
        apart[precision] = np.abs(found - exact_frame(ball, modifier)).max()
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    rounding = np.finfo(np.float32).eps * np.abs(found).max()
    assert 0.0 < apart["DOUBLE"] <= rounding
    assert apart["DOUBLE"] < apart["SINGLE"] < 20 * rounding


def test_the_error_shown_is_that_of_the_vertices_shown(preferences):
    preferences.precision = "DOUBLE"
    ball, _lattice, modifier = squashed_ball()
    bpy.context.scene.frame_set(6)
    volumes = scenes.report(ball, modifier).volumes
    assert np.isclose(volumes.after, scenes.evaluated_volume(ball), rtol=1e-12)
    assert volumes.error == abs(volumes.after - volumes.target) / volumes.target > 0.0
    assert volumes.before < 0.9 * volumes.target


def test_double_computes_on_the_cpu_whatever_the_device(preferences):
    preferences.precision = "DOUBLE"
    preferences.device = "GPU"
    try:
        ball, _lattice, modifier = squashed_ball()
        bpy.context.scene.frame_set(6)
        assert scenes.report(ball, modifier).device == "cpu"
    finally:
        preferences.device = "AUTO"


def test_double_with_a_chain_of_modifiers_and_without_correction(preferences):
    preferences.precision = "DOUBLE"
    ball, lattice, modifier = squashed_ball(Preserve=0.0)
    second = scenes.volume_lattice(ball, scenes.lattice_object(4, name="Second"), Preserve=0.0)
    bpy.context.scene.frame_set(6)
    assert not scenes.report(ball, modifier).problems
    assert not scenes.report(ball, second).problems
    shrunk = scenes.evaluated_volume(ball)
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    assert abs(shrunk / scenes.volume(ball.data) - 1) > 0.05
    assert lattice.name in bpy.data.objects


def test_a_loop_computes_nothing_from_its_third_round_on_and_shows_the_same_bits(preferences, solves):
    preferences.memory = 0
    ball, _lattice, _ = squashed_ball()
    first = play(ball)
    count = len(solves)
    again = play(ball)
    assert len(solves) == count + FRAMES
    preferences.memory = 64
    play(ball)
    play(ball)
    count = len(solves)
    looped = play(ball)
    assert len(solves) == count
    for one, other, kept in zip(first, again, looped, strict=True):
        assert np.array_equal(one, other)
        assert np.array_equal(one, kept)
    for frame in (7, 3, 11, 2):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(scenes.evaluated_positions(ball), first[frame - 1])
    assert len(solves) == count


def test_a_mesh_that_changes_before_the_modifier_and_a_moving_lattice_are_kept_too(solves):
    ball, lattice, modifier = squashed_ball(Strength=0.9)
    wave = ball.modifiers.new("Wave", "WAVE")
    wave.height = 0.1
    ball.modifiers.move(1, 0)
    for frame, place in ((1, 0.0), (FRAMES, 0.1)):
        lattice.location.x = place
        lattice.keyframe_insert("location", frame=frame)
    first = play(ball)
    known = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        report = scenes.report(ball, modifier)
        known.append((report.volumes, report.vertices_outside))
    play(ball)
    count = len(solves)
    for frame, shape in enumerate(play(ball), start=1):
        assert np.array_equal(shape, first[frame - 1])
    assert len(solves) == count
    scenes.part("tool.frame_memory").clear()
    play(ball)
    play(ball)
    count = len(solves)
    for frame in (5, 9, 2):
        # Asked for the first time of a frame that comes out of memory, when others were computed in between.
        bpy.context.scene.frame_set(frame)
        report = scenes.report(ball, modifier)
        assert report.volumes == known[frame - 1][0]
        assert report.vertices_outside == known[frame - 1][1]
    assert len(solves) == count
    assert len({volumes.target for volumes, _ in known}) == 1
    assert len({volumes.before for volumes, _ in known}) == FRAMES


def test_an_edit_or_a_setting_is_never_answered_from_memory():
    ball, lattice, modifier = squashed_ball()
    for _ in range(3):
        play(ball)
    bpy.context.scene.frame_set(6)
    before = scenes.evaluated_positions(ball)
    scenes.set_input(modifier, "Axes", (1.0, 0.0, 0.0))
    bpy.context.view_layer.update()
    sideways = scenes.evaluated_positions(ball)
    assert np.abs(sideways - before).max() > 0.01
    scenes.set_input(modifier, "Axes", (1.0, 1.0, 1.0))
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball), before)
    ball.data.vertices[3].co *= 1.01
    ball.data.update_tag()
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball)[3] - before[3]).max() > 1e-3
    lattice.data.shape_keys.key_blocks["Squash"].data[93].co.x += 0.5
    lattice.data.update_tag()
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - before).max() > 0.02


def test_memory_stays_within_its_limit_is_shown_and_cleared(preferences):
    frame_memory = scenes.part("tool.frame_memory")
    ball = scenes.sphere(150, 150)
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    preferences.memory = 2
    play(ball)
    assert frame_memory.used()[0] <= 1  # the frame in which the modifier was added may have been seen before
    play(ball)
    count, used = frame_memory.used()
    one = 12 * len(ball.data.vertices)
    assert 2 <= count < FRAMES
    assert count * one < used <= 2 << 20
    assert scenes.part("ui.preferences").memory_used() == f"{count} frames kept, {used / (1 << 20):.1f} MB"
    preferences.memory = 1
    assert frame_memory.used()[1] <= 1 << 20
    assert bpy.ops.isochor.clear_memory() == {"FINISHED"}
    assert frame_memory.used() == (0, 0)
    preferences.memory = 0
    for _ in range(3):
        play(ball)
    assert frame_memory.used() == (0, 0)


def test_what_the_preferences_draw(preferences):
    layout = Layout()
    kind = type(preferences)
    owner = SimpleNamespace(layout=layout, device="NAMED")
    kind.draw(owner, bpy.context)
    assert {"device", "adapter", "precision", "memory", "isochor.clear_memory"} <= set(layout.lines)
    assert "0 frames kept, 0.0 MB" in layout.lines


def test_shared_arrays_are_counted_once_and_freed_with_the_last_frame():
    frames = scenes.part("core.frames").Frames(limit=1 << 20)
    ball, _lattice, modifier = squashed_ball()
    requests = []
    for frame in (2, 5, 8):
        bpy.context.scene.frame_set(frame)
        memory = scenes.part("tool.state").recall(ball, modifier)
        requests.append((memory.solver._answered, memory.solver._outcome))
    for _ in range(2):
        for request, outcome in requests:
            frames.keep(ball, request, outcome)
    positions = requests[0][0].positions
    control = requests[0][0].control
    own = requests[0][1].vertices.nbytes + 2 * control.nbytes
    assert all(request.positions is positions for request, _ in requests)
    assert (len(frames), frames.used) == (3, positions.nbytes + 3 * own)
    assert frames.find(ball, requests[1][0]) is requests[1][1]
    frames.resize(frames.used - 1)
    assert frames.find(ball, requests[0][0]) is None
    assert frames.used == positions.nbytes + 2 * own
    frames.forget(ball)
    assert (len(frames), frames.used) == (0, 0)
