# SPDX-License-Identifier: GPL-3.0-or-later
"""The deformation alone (Preserve = 0) against an independent evaluation, on what Blender evaluates."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix


def placed(obj: bpy.types.Object, location, rotation, scale) -> None:
    obj.matrix_world = Matrix.LocRotScale(location, Euler(rotation), scale)


def bent(lattice: bpy.types.Object, seed: int = 7, strength: float = 0.12) -> None:
    """Moves every point of the lattice some way."""
    random = np.random.default_rng(seed)
    for point in lattice.data.points:
        point.co_deform = np.array(point.co_deform) + random.uniform(-strength, strength, 3)


def rotated_scene(side, size: float):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(side)
    placed(ball, (3.0, -2.0, 1.5), (0.4, -0.8, 1.9), (1.4, 0.7, 1.1))
    placed(lattice, (3.05, -1.97, 1.52), (0.1, 0.3, -0.5), (size, size * 1.1, size * 0.9))
    return ball, lattice


CASES = [
    ("Bernstein", (4, 4, 4), 4.2),
    ("Bernstein", (2, 7, 5), 4.2),
    ("B-Spline", (6, 6, 6), 7.5),
    ("B-Spline", 10, 5.5),
]


@pytest.mark.parametrize(("basis", "side", "size"), CASES)
def test_agrees_with_numpy_for_rotated_scaled_and_moved_object_and_lattice(basis, side, size):
    ball, lattice = rotated_scene(side, size)
    before = scenes.positions(ball.data)
    scenes.volume_lattice(ball, lattice, Basis=basis, Preserve=0.0)
    bent(lattice)
    bpy.context.view_layer.update()
    found = scenes.evaluated_positions(ball)
    expected = lattice_oracle.deformed(ball, lattice, before, basis)
    extent = np.ptp(before, axis=0).max()
    assert np.abs(expected - before).max() > 0.05 * extent
    assert np.abs(found - expected).max() <= 1e-6 * extent


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_untouched_lattice_moves_nothing_wherever_it_stands(basis):
    ball, lattice = rotated_scene(6, 7.5)
    scenes.volume_lattice(ball, lattice, Basis=basis)
    lattice.location.x += 0.3
    lattice.rotation_euler.z += 0.2
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 2e-6


def test_vertices_outside_are_kept_or_follow():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=1.2)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0)
    before = scenes.positions(ball.data)
    outside = np.any(np.abs(before) > 0.6 + 1e-6, axis=1)
    bent(lattice)
    bpy.context.view_layer.update()
    moved = np.abs(scenes.evaluated_positions(ball) - before).max(axis=1) > 1e-5
    assert outside.any()
    assert not moved[outside].any()
    assert scenes.report(ball, modifier).vertices_outside == outside.sum()
    scenes.set_input(modifier, "Outside", "Extend")
    bpy.context.view_layer.update()
    moved = np.abs(scenes.evaluated_positions(ball) - before).max(axis=1) > 1e-5
    assert moved[outside].mean() > 0.9


def test_strength_and_vertex_group_scale_each_vertex():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0)
    bent(lattice)
    bpy.context.view_layer.update()
    before, full = scenes.positions(ball.data), scenes.evaluated_positions(ball)
    group = ball.vertex_groups.new(name="Part")
    weights = np.linspace(0.0, 1.0, len(before))
    for index in range(1, len(before)):
        group.add([index], weights[index], "REPLACE")
    scenes.set_input(modifier, "Strength", 0.5)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - (before + 0.5 * (full - before))).max() < 1e-6
    scenes.set_input(modifier, "Vertex Group", "Part")
    bpy.context.view_layer.update()
    masked = before + 0.5 * weights[:, None] * (full - before)
    assert np.abs(scenes.evaluated_positions(ball) - masked).max() < 1e-6
    scenes.set_input(modifier, "Invert", True)
    scenes.set_input(modifier, "Strength", 1.0)
    bpy.context.view_layer.update()
    inverted = before + (1.0 - weights)[:, None] * (full - before)
    assert np.abs(scenes.evaluated_positions(ball) - inverted).max() < 1e-6


def test_flat_lattice_of_one_layer_moves_what_it_holds():
    ball = scenes.sphere()
    lattice = scenes.lattice_object((4, 4, 1))
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 2e-6
    for point in lattice.data.points:
        point.co_deform.x *= 0.5
    lattice.update_tag()
    bpy.context.view_layer.update()
    narrow = scenes.evaluated_positions(ball)
    assert np.abs(narrow[:, 0] - 0.5 * scenes.positions(ball.data)[:, 0]).max() < 1e-5


def test_lattice_data_made_by_a_script_without_the_unit_cube():
    """Blender spaces the points of lattice data that no object has yet one unit apart, instead of over a unit cube."""
    ball = scenes.sphere()
    data = bpy.data.lattices.new("Wide")
    data.points_u = data.points_v = data.points_w = 4
    lattice = bpy.data.objects.new("Wide", data)
    bpy.context.scene.collection.objects.link(lattice)
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 2e-6
    for point in data.points:
        point.co_deform.z *= 0.5
    bpy.context.view_layer.update()
    flat = scenes.evaluated_positions(ball)
    assert np.abs(flat[:, 2] - 0.5 * scenes.positions(ball.data)[:, 2]).max() < 2e-6
