# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume of what Blender evaluates, in float64 over its triangles."""

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix


def squashed(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def relative(found: float, expected: float) -> float:
    return abs(found - expected) / abs(expected)


@pytest.mark.parametrize("method", ["Balanced", "Sweep"])
@pytest.mark.parametrize(
    ("basis", "side", "size"), [("Bernstein", 4, 2.6), ("B-Spline", 6, 4.2), ("B-Spline", 10, 3.2)]
)
def test_volume_is_kept(method, basis, side, size):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(side, size=size)
    modifier = scenes.volume_lattice(ball, lattice, Basis=basis, Method=method)
    whole = scenes.volume(ball.data)
    squashed(lattice, 0.4)
    assert relative(scenes.evaluated_volume(ball), whole) <= 1e-6
    report = scenes.report(ball, modifier)
    assert report.problems == ()
    assert relative(report.volumes.target, whole) <= 1e-6
    assert report.volumes.error <= 1e-6
    assert report.volumes.before == pytest.approx(0.4 * whole, rel=1e-5)
    assert report.result.method == method.lower()
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    assert relative(scenes.evaluated_volume(ball), 0.4 * whole) < 1e-5


def test_preserve_between_zero_and_one_restores_that_part():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Preserve=0.25)
    whole = scenes.volume(ball.data)
    squashed(lattice, 0.4)
    assert relative(scenes.evaluated_volume(ball), (0.4 + 0.25 * 0.6) * whole) < 1e-5


def test_target_is_a_factor_on_the_volume():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Target=1.3)
    whole = scenes.volume(ball.data)
    bpy.context.view_layer.update()
    assert relative(scenes.evaluated_volume(ball), 1.3 * whole) <= 1e-6


def test_horizontal_shares_leave_every_height_alone():
    ball = scenes.sphere(64, 40)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0)
    squashed(lattice, 0.36)
    plain = scenes.evaluated_positions(ball)
    scenes.set_input(modifier, "Axes", (1.0, 1.0, 0.0))
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    found = scenes.evaluated_positions(ball)
    assert relative(scenes.evaluated_volume(ball), scenes.volume(ball.data)) <= 1e-6
    assert np.array_equal(found[:, 2], plain[:, 2])
    assert np.abs(found[:, :2] - plain[:, :2]).max() > 0.1


def test_shares_in_global_space_mean_the_world_for_a_turned_object():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    turn = Matrix.LocRotScale((1.0, 2.0, 3.0), Euler((0.9, 0.4, -0.3)), (1.2, 0.8, 1.0))
    ball.matrix_world = turn
    lattice.matrix_world = turn @ Matrix.Scale(2.6, 4)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0, Axes=(1.0, 1.0, 0.0))
    squashed(lattice, 0.5)
    world = np.array(ball.matrix_world, np.float64)
    in_lattice = np.linalg.inv(np.array(lattice.matrix_world, np.float64)) @ world

    def change(space: str, transform: np.ndarray) -> np.ndarray:
        scenes.set_input(modifier, "Preserve", 0.0)
        bpy.context.view_layer.update()
        plain = scenes.evaluated_positions(ball)
        scenes.set_input(modifier, "Space", space)
        scenes.set_input(modifier, "Preserve", 1.0)
        bpy.context.view_layer.update()
        assert relative(scenes.evaluated_volume(ball), scenes.volume(ball.data)) <= 1e-6
        return np.abs((scenes.evaluated_positions(ball) - plain) @ transform[:3, :3].T).max(axis=0)

    for space, transform in (("Global", world), ("Object", np.eye(4)), ("Lattice", in_lattice)):
        x, y, z = change(space, transform)
        assert min(x, y) > 0.03, space
        assert z < 2e-6, space
    scenes.set_input(modifier, "Space", "Global")
    bpy.context.view_layer.update()


def test_rest_brings_back_what_was_lost_before_the_lattice_and_incoming_does_not():
    ball = scenes.sphere()
    ball.shape_key_add(name="Basis")
    thin = ball.shape_key_add(name="Thin")
    thin.value = 0.0
    for point in thin.data:
        point.co.x *= 0.5
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    whole = scenes.volume(ball.data)
    thin.value = 1.0
    bpy.context.view_layer.update()
    assert relative(scenes.evaluated_volume(ball), whole) <= 1e-6
    scenes.set_input(modifier, "Reference", "Incoming")
    bpy.context.view_layer.update()
    assert relative(scenes.evaluated_volume(ball), 0.5 * whole) <= 1e-5


def test_strength_and_mask_still_keep_the_volume():
    ball = scenes.sphere()
    group = ball.vertex_groups.new(name="Upper")
    group.add([v.index for v in ball.data.vertices if v.co.z > 0], 1.0, "REPLACE")
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Strength=0.8, Vertex_Group="Upper")
    squashed(lattice, 0.4)
    assert relative(scenes.evaluated_volume(ball), scenes.volume(ball.data)) <= 1e-6
    low = scenes.positions(ball.data)[:, 2] <= 0
    assert np.array_equal(scenes.evaluated_positions(ball)[low], scenes.positions(ball.data)[low])
    assert scenes.report(ball, modifier).problems == ()


def test_quads_and_larger_faces_keep_the_volume_over_the_incoming_triangles():
    bpy.ops.mesh.primitive_cylinder_add(vertices=12)
    cylinder = bpy.context.object
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(cylinder, lattice, Axes=(1.0, 1.0, 0.0))
    squashed(lattice, 0.5)
    assert scenes.report(cylinder, modifier).volumes.error <= 1e-6
    assert relative(scenes.evaluated_volume(cylinder), scenes.volume(cylinder.data)) < 1e-5


def test_inside_out_mesh_is_kept_and_the_report_says_so():
    ball = scenes.sphere()
    ball.data.flip_normals()
    whole = scenes.volume(ball.data)
    assert whole < 0
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squashed(lattice, 0.5)
    assert relative(scenes.evaluated_volume(ball), whole) <= 1e-6
    assert scenes.report(ball, modifier).inside_out


def test_sidebar_tells_the_numbers():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=1.9)
    modifier = scenes.volume_lattice(ball, lattice)
    squashed(lattice, 0.5)
    told = dict(scenes.part("ui.sidebar").rows(scenes.report(ball, modifier)))
    assert float(told["Target volume"]) == pytest.approx(scenes.volume(ball.data), rel=1e-5)
    assert float(told["Corrected"]) == pytest.approx(scenes.volume(ball.data), rel=1e-5)
    assert "%)" in told["Lattice alone"]
    assert float(told["Error"]) <= 1e-6
    assert float(told["Points moved up to"]) > 0.0
    assert int(told["Vertices outside"]) > 0
    assert told["Computed on"] == "cpu"
    assert float(told["Time"].removesuffix(" ms")) > 0.0
