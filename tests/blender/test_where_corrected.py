# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the correction acts: a stiff half, where the loss is, along or across the axes of an object."""

import re

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix

EXACT = 1e-6


def squashed(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def shown_with(modifier: bpy.types.NodesModifier, **inputs) -> None:
    for name, value in inputs.items():
        scenes.set_input(modifier, name.replace("_", " "), value)
    bpy.context.view_layer.update()


def moves(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> np.ndarray:
    """(nu, nv, nw, 3) what the correction did to the control points, in object space."""
    report = scenes.report(obj, modifier)
    assert report.problems == ()
    return report.result.control - report.asked


def layers_with_weights(lattice: bpy.types.Object, weights: list[float], name: str = "Stiff") -> None:
    """A vertex group with one weight for each layer along z."""
    group = lattice.vertex_groups.new(name=name)
    shape = lattice.data.points_u, lattice.data.points_v
    layer = shape[0] * shape[1]
    for number, weight in enumerate(weights):
        group.add(list(range(number * layer, (number + 1) * layer)), weight, "REPLACE")


def test_a_stiff_half_stays_still_and_the_volume_is_kept_all_the_same():
    ball = scenes.sphere(32, 24)
    lattice = scenes.lattice_object(8, size=4.2)
    layers_with_weights(lattice, [1.0] * 5 + [0.0] * 3)
    modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline", Preserve=0.0)
    squashed(lattice)
    plain = scenes.evaluated_positions(ball)
    shown_with(modifier, Preserve=1.0)
    everywhere = np.abs(scenes.evaluated_positions(ball) - plain).max(axis=1)
    shown_with(modifier, Stiffness="Stiff")
    found = scenes.evaluated_positions(ball)
    moved = moves(ball, modifier)
    assert np.all(moved[:, :, :5] == 0.0)
    assert np.abs(moved[:, :, 5:]).max() > 0.05
    low = plain[:, 2] < -0.2
    assert low.sum() > 100
    assert everywhere[low].max() > 0.05
    assert np.abs(found[low] - plain[low]).max() < 1e-6
    assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=EXACT)


def test_a_point_of_stiffness_s_moves_one_minus_s_as_far():
    """Along one axis the correction of each point is in proportion to its pull on the volume, over its weight."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    layers_with_weights(lattice, [0.0, 0.25, 0.5, 0.9])
    modifier = scenes.volume_lattice(ball, lattice, Axes=(1.0, 0.0, 0.0), Method="Sweep")
    squashed(lattice)
    free = moves(ball, modifier)[..., 0]
    shown_with(modifier, Stiffness="Stiff")
    stiff = moves(ball, modifier)[..., 0]
    pulled = np.abs(free) > 1e-3 * np.abs(free).max()
    share = np.where(pulled, stiff / np.where(pulled, free, 1.0), np.nan)
    by_layer = np.nanmean(share, axis=(0, 1))
    assert np.nanmax(np.abs(share - by_layer)) < 1e-6
    assert by_layer / by_layer[0] == pytest.approx([1.0, 0.75, 0.5, 0.1], rel=1e-5)
    assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=EXACT)


def test_stiffness_follows_edits_of_the_group_and_says_where_it_is_missing():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Stiffness="Stiff")
    squashed(lattice)
    problems = scenes.report(ball, modifier).problems
    assert any("“Lattice” has no vertex group “Stiff”" in text for text in problems)
    assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=EXACT)
    layers_with_weights(lattice, [1.0, 0.0, 0.0, 0.0])
    bpy.context.view_layer.update()
    assert np.all(moves(ball, modifier)[:, :, 0] == 0.0)
    assert np.abs(moves(ball, modifier)[:, :, 3]).max() > 0.01
    lattice.vertex_groups["Stiff"].add(list(range(48, 64)), 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert np.all(moves(ball, modifier)[:, :, 3] == 0.0)


def test_stiffness_in_edit_mode_of_the_lattice_is_that_from_before():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    layers_with_weights(lattice, [1.0, 0.0, 0.0, 0.0])
    modifier = scenes.volume_lattice(ball, lattice, Stiffness="Stiff")
    squashed(lattice)
    before = moves(ball, modifier)
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.update()
    assert np.abs(moves(ball, modifier) - before).max() < 1e-6
    bpy.ops.lattice.select_all(action="SELECT")
    bpy.ops.transform.translate(value=(0.1, 0.0, 0.0))
    bpy.context.view_layer.update()
    assert np.all(moves(ball, modifier)[:, :, 0] == 0.0)
    shown_with(modifier, Stiffness="Other")
    assert any("Edit Mode" in text for text in scenes.report(ball, modifier).problems)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert any("no vertex group “Other”" in text for text in scenes.report(ball, modifier).problems)


def test_with_every_point_frozen_the_volume_cannot_be_reached_and_that_is_said():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    layers_with_weights(lattice, [1.0] * 4)
    modifier = scenes.volume_lattice(ball, lattice, Stiffness="Stiff")
    squashed(lattice)
    said = " ".join(scenes.report(ball, modifier).problems)
    assert "cannot be reached" in said
    assert "stiff" in said
    reachable = float(re.search(r"only ([\d.]+):", said)[1])
    assert reachable == pytest.approx(0.5 * scenes.volume(ball.data), rel=1e-5)
    assert scenes.evaluated_volume(ball) == pytest.approx(0.5 * scenes.volume(ball.data), rel=1e-5)


def test_the_correction_goes_where_the_volume_went():
    """A body pinched at one end: with Where Lost the other end stays nearer to what the animator set."""
    ball = scenes.sphere(32, 24)
    lattice = scenes.lattice_object(8, size=4.2)
    modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    for point in lattice.data.points:
        if point.co_deform.z > 0.05:
            point.co_deform.x *= 0.4
            point.co_deform.y *= 0.4
    bpy.context.view_layer.update()
    away = {}
    for share in (0.0, 0.5, 1.0):
        shown_with(modifier, Where_Lost=share)
        moved = np.linalg.norm(moves(ball, modifier), axis=-1)
        away[share] = moved[:, :, :3].max() / moved.max()
        assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=EXACT)
    assert away[1.0] < 0.2 * away[0.0]
    assert away[1.0] < away[0.5] < away[0.0]


@pytest.mark.parametrize("method", ["Balanced", "Sweep", "Gradient", "Nearest"])
@pytest.mark.parametrize("axes", [(0.0, 0.0, 1.0), (1.0, 1.0, 0.0)])
def test_a_frame_of_its_own_moves_along_its_axes_only(method, axes):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    bpy.context.view_layer.update()
    ball.matrix_world = Matrix.LocRotScale((1.0, 2.0, 3.0), Euler((0.9, 0.4, -0.3)), (1.2, 0.8, 1.0))
    lattice.matrix_world = ball.matrix_world @ lattice.matrix_world
    frame = bpy.data.objects.new("Frame", None)
    bpy.context.scene.collection.objects.link(frame)
    frame.matrix_world = Matrix.LocRotScale((5.0, 0.0, 0.0), Euler((0.3, -0.8, 1.1)), (2.0, 2.0, 2.0))
    modifier = scenes.volume_lattice(ball, lattice, Space="Custom", Frame=frame, Axes=axes, Method=method)
    squashed(lattice, 0.7)
    for turned in (False, True):
        if turned:
            frame.rotation_euler.y += 0.7
            bpy.context.view_layer.update()
        world = moves(ball, modifier) @ np.array(ball.matrix_world)[:3, :3].T
        own = world @ np.array(frame.matrix_world.normalized())[:3, :3]
        still = np.array(axes) == 0.0
        assert np.abs(own[..., still]).max() < 1e-6 * np.abs(own).max()
        assert np.abs(own).max() > 0.05
        assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=EXACT)


def test_without_an_object_or_with_a_flat_one_the_axes_of_the_world_count_and_that_is_said():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Axes=(1.0, 0.0, 0.0))
    squashed(lattice)
    world = scenes.evaluated_positions(ball)
    shown_with(modifier, Space="Custom")
    assert any("no object under Frame" in text for text in scenes.report(ball, modifier).problems)
    assert np.abs(scenes.evaluated_positions(ball) - world).max() < 1e-6
    frame = bpy.data.objects.new("Frame", None)
    bpy.context.scene.collection.objects.link(frame)
    frame.rotation_euler.z = 1.0
    frame.scale.x = 0.0
    shown_with(modifier, Frame=frame)
    assert any("“Frame” has a scale of zero" in text for text in scenes.report(ball, modifier).problems)
    assert np.abs(scenes.evaluated_positions(ball) - world).max() < 1e-6
    frame.scale.x = 1.0
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert np.abs(scenes.evaluated_positions(ball) - world).max() > 0.05
