# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of a lattice's points: a vertex group of the lattice, and how heavy its points are."""

from math import comb

import bpy
import native_scenes
import numpy as np
import pytest
import scenes
from numpy.typing import NDArray

CLOSE = 1e-6


def scene(basis: str = "Bernstein", **inputs):
    ball = scenes.sphere()
    lattice = native_scenes.shaken((4, 3, 5), ("KEY_BSPLINE",) * 3, 2.6)
    native_scenes.group(lattice, "Heavy")
    modifier = scenes.volume_lattice(ball, lattice, Basis=basis, **inputs)
    return ball, lattice, modifier


def rational(points: NDArray, lattice: bpy.types.Object, weights: NDArray, size: float) -> NDArray:
    """Where a Bernstein lattice of ``size`` about the origin takes points, by Sederberg's quotient of displacements."""
    shape = lattice.data.points_u, lattice.data.points_v, lattice.data.points_w
    moved = np.array([np.subtract(point.co_deform, point.co) for point in lattice.data.points]) * size
    moved = moved.reshape(*shape[::-1], 3).transpose(2, 1, 0, 3)
    shares = []
    for axis, count in enumerate(shape):
        t = points[:, axis] / size + 0.5
        shares.append(np.stack([comb(count - 1, i) * t**i * (1 - t) ** (count - 1 - i) for i in range(count)], axis=-1))
    over = np.einsum("pi,pj,pk,ijk->p", *shares, weights)
    return points + np.einsum("pi,pj,pk,ijk,ijkx->px", *shares, weights, moved) / over[:, None]


def group_weights(lattice: bpy.types.Object, name: str = "Heavy") -> NDArray:
    return scenes.part("tool.lattice_weights").of_group(lattice, name)


@pytest.mark.parametrize("heaviest", [10.0, 0.2])
def test_the_shape_is_that_of_the_rational_lattice(heaviest):
    ball, lattice, modifier = scene(Weights="Heavy", Heaviest=heaviest, Preserve=0.0)
    weights = 1.0 + group_weights(lattice) * (heaviest - 1.0)
    wanted = rational(scenes.positions(ball.data), lattice, weights, 2.6)
    shown = scenes.evaluated_positions(ball)
    assert native_scenes.apart(shown, wanted) <= CLOSE
    scenes.set_input(modifier, "Weights", "")
    bpy.context.view_layer.update()
    assert native_scenes.apart(shown, scenes.evaluated_positions(ball)) > 0.01


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline", "Blender"])
@pytest.mark.parametrize("method", ["Balanced", "Sweep", "Gradient", "Nearest"])
def test_the_volume_is_kept_as_exactly_as_without(basis, method):
    ball, _lattice, modifier = scene(basis, Weights="Heavy", Method=method, Outside="Extend")
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    corrected = scenes.evaluated_positions(ball)
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    assert native_scenes.apart(corrected, scenes.evaluated_positions(ball)) > 1e-4


def test_a_heavy_point_draws_the_shape_towards_itself():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(3)
    lattice.vertex_groups.new(name="Top").add([22], 1.0, "REPLACE")
    lattice.data.points[22].co_deform.z += 0.4
    scenes.volume_lattice(ball, lattice, Weights="Top", Preserve=0.0)
    heights = []
    for heaviest in (0.1, 1.0, 10.0, 100.0):
        scenes.set_input(ball.modifiers[0], "Heaviest", heaviest)
        bpy.context.view_layer.update()
        heights.append(scenes.evaluated_positions(ball)[:, 2].max())
    assert heights == sorted(set(heights))
    assert heights[-1] > heights[1] + 0.2


def test_equal_weights_are_none():
    ball, lattice, modifier = scene(Preserve=0.0)
    before = scenes.evaluated_positions(ball)
    lattice.vertex_groups.new(name="All").add(range(60), 0.5, "REPLACE")
    lattice.data.update_tag()
    scenes.set_input(modifier, "Weights", "All")
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball), before)
    scenes.set_input(modifier, "Weights", "Heavy")
    scenes.set_input(modifier, "Heaviest", 1.0)
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball), before)
    assert scenes.report(ball, modifier).grid.weights is None


def test_edits_of_the_group_are_followed_and_what_is_wrong_is_said():
    ball, lattice, modifier = scene(Weights="Heavy", Preserve=0.0)
    before = scenes.evaluated_positions(ball)
    lattice.vertex_groups["Heavy"].add(range(30), 1.0, "REPLACE")
    lattice.data.update_tag()
    bpy.context.view_layer.update()
    edited = scenes.evaluated_positions(ball)
    assert native_scenes.apart(before, edited) > 0.005
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.update()
    assert native_scenes.apart(scenes.evaluated_positions(ball), edited) <= CLOSE
    scenes.set_input(modifier, "Weights", "Other")
    bpy.context.view_layer.update()
    assert any("The Weights of “Cage” is read again" in text for text in scenes.report(ball, modifier).problems)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    said = scenes.report(ball, modifier).problems
    assert any("no vertex group “Other”" in text and "input Weights" in text for text in said)
    scenes.set_input(modifier, "Weights", "")
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()


def test_a_keyed_heaviest_and_a_bound_rest():
    ball, lattice, modifier = scene(Weights="Heavy", Preserve=1.0)
    path = scenes.part("tool.drivers").data_path(modifier, "Heaviest")
    for frame, heaviest in ((1, 1.0), (5, 20.0)):
        scenes.set_input(modifier, "Heaviest", heaviest)
        ball.keyframe_insert(path, frame=frame)
    bpy.context.scene.frame_set(1)
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    for frame in (1, 3, 5):
        bpy.context.scene.frame_set(frame)
        assert scenes.report(ball, modifier).problems == ()
        assert native_scenes.apart(scenes.evaluated_positions(ball), scenes.positions(ball.data)) <= 2 * CLOSE
    lattice.data.points[30].co_deform.z += 0.3
    shown = []
    for frame in (1, 3, 5):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
        shown.append(scenes.evaluated_positions(ball))
    assert native_scenes.apart(shown[0], shown[-1]) > 0.001


def test_a_lattice_bake_is_refused():
    ball, _lattice, _modifier = scene(Weights="Heavy")
    scenes.choose(ball)
    with pytest.raises(RuntimeError, match="have weights"):
        bpy.ops.isochor.bake(format="LATTICE", frame_start=1, frame_end=2)
