# SPDX-License-Identifier: GPL-3.0-or-later
"""deform, evaluate and parameters against the oracle's dense textbook evaluation."""

import isochor
import lattices
import meshes
import numpy as np
import pytest
from lattices import BSPLINE, SOLID, THIN
from oracle import Embedded, Spec

EVERY = {**SOLID, **THIN}
each_lattice = pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
each_solid = pytest.mark.parametrize("spec", SOLID.values(), ids=SOLID)
EPSILON = {np.float64: 2.3e-16, np.float32: 1.2e-7}


def library_rest(spec: Spec):
    """The library's own rest points: with one control point on an axis its place is the library's choice."""
    return spec.build().rest


@each_solid
@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("amount", [0.1, 2.0])
def test_deform_is_the_oracle(spec, dtype, amount):
    points = lattices.points_inside(spec, dtype)
    control = lattices.noisy(spec, amount)
    out = spec.build().bind(points, device="cpu").deform(control)
    expected = Embedded.of(spec, points, np.zeros((0, 3), int)).deform(control)
    atol = spec.rounding(np.abs(control).max() + np.abs(spec.rest).max(), EPSILON[dtype])
    np.testing.assert_allclose(out, expected, rtol=0, atol=atol)


def test_the_comparison_can_fail():
    """Tripwire: one control point moved by a millionth must show."""
    spec = Spec()
    points, control = lattices.points_inside(spec), lattices.noisy(spec)
    wrong = control.copy()
    wrong[1, 2, 1, 0] += 1e-6
    out = spec.build().bind(points, device="cpu").deform(wrong)
    expected = Embedded.of(spec, points, np.zeros((0, 3), int)).deform(control)
    assert np.abs(out - expected).max() > 100 * spec.rounding(control, EPSILON[np.float64])


@each_lattice
def test_parameters_are_the_affine_coordinates_of_the_domain(spec):
    points = np.concatenate([lattices.points_inside(spec), 3 * lattices.points_inside(spec, count=20, seed=9)])
    parameters = spec.build().parameters(points)
    assert parameters.dtype == np.float64
    edges = np.asarray(spec.edges, dtype=float)
    back = parameters @ edges + spec.origin
    np.testing.assert_allclose(back, points, rtol=0, atol=1e-14 * np.abs(points).max() * 4)
    np.testing.assert_allclose(parameters, spec.parameters(points), rtol=1e-9, atol=1e-12 * np.abs(parameters).max())


@each_solid
def test_evaluate_is_the_oracle(spec):
    parameters = np.random.default_rng(6).random((150, 3))
    parameters[:8] = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), axis=-1).reshape(-1, 3)
    control = lattices.noisy(spec, 0.6)
    out = spec.build().evaluate(parameters, control)
    assert out.dtype == np.float64
    assert out.shape == (150, 3)
    expected = spec.matrix(parameters) @ control.reshape(-1, 3)
    np.testing.assert_allclose(out, expected, rtol=0, atol=spec.rounding(control, EPSILON[np.float64]))


@each_lattice
def test_evaluate_after_parameters_is_deform(spec):
    points = lattices.points_inside(spec)[:-8]
    lattice = spec.build()
    control = library_rest(spec) + lattices.noisy(spec, 0.3) - spec.rest
    out = lattice.evaluate(lattice.parameters(points), control)
    atol = spec.rounding(np.abs(control).max() + np.abs(points).max(), EPSILON[np.float64])
    np.testing.assert_allclose(out, lattice.bind(points, device="cpu").deform(control), rtol=0, atol=atol)


@pytest.mark.parametrize("name", ["bspline-knot-arrays", "bspline-3-uniform", "bspline-5-clamped"])
def test_evaluate_on_the_knots_themselves(name):
    spec = BSPLINE[name]
    knots = np.unique(np.clip(spec.knot_vector(0), 0, 1))
    beside = np.clip(np.concatenate([knots, np.nextafter(knots, -1), np.nextafter(knots, 2)]), 0, 1)
    parameters = np.stack([beside, np.full(len(beside), 0.3), beside[::-1]], axis=1)
    control = lattices.noisy(spec, 0.6)
    expected = spec.matrix(parameters) @ control.reshape(-1, 3)
    np.testing.assert_allclose(spec.build().evaluate(parameters, control), expected, rtol=0, atol=1e-13)


def test_knots_over_another_interval_are_the_same_lattice():
    """(s, t, u) runs over [0, 1]³ whatever numbers the knots are counted in."""
    spec = BSPLINE["bspline-knot-arrays"]
    counted = tuple(3 * np.asarray(axis, dtype=float) + 5 for axis in spec.knots)
    lattice = isochor.Lattice(shape=spec.shape, basis="bspline", degree=3, knots=counted)
    np.testing.assert_allclose(lattice.rest, spec.rest, rtol=0, atol=1e-14)
    parameters, control = np.random.default_rng(1).random((50, 3)), lattices.noisy(spec)
    expected = spec.matrix(parameters) @ control.reshape(-1, 3)
    np.testing.assert_allclose(lattice.evaluate(parameters, control), expected, rtol=0, atol=1e-13)


def test_default_lattice_is_bernstein_on_the_unit_cube():
    lattice = isochor.Lattice(shape=(4, 3, 5))
    np.testing.assert_allclose(lattice.rest, Spec((4, 3, 5)).rest, rtol=0, atol=1e-15)


def test_default_bspline_is_uniform():
    lattice = isochor.Lattice(shape=(6, 6, 6), basis="bspline", degree=3)
    np.testing.assert_allclose(lattice.rest, Spec((6, 6, 6), "bspline", 3, "uniform").rest, rtol=0, atol=1e-15)


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("basis", ["bernstein", "bspline"])
def test_around_fits_the_box_of_the_points(basis, dtype):
    vertices = (meshes.bumpy_ball()[0] * [3, 0.2, 70] + [5, -3, 100]).astype(dtype)
    lattice = isochor.Lattice.around(vertices, shape=(5, 4, 6), basis=basis)
    parameters = lattice.parameters(vertices)
    np.testing.assert_allclose(parameters.min(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(parameters.max(axis=0), 1, atol=1e-12)
    assert lattice.rest.shape == (5, 4, 6, 3)


def test_every_vertex_of_a_fitted_lattice_is_inside():
    """The box's own extreme vertices may fall outside by rounding; parameters within 1e-9 count as inside."""
    for seed in range(40):
        random = np.random.default_rng(seed)
        vertices = random.normal(size=(50, 3)) * random.uniform(0.01, 100, 3) + random.normal(size=3) * 100
        lattice = isochor.Lattice.around(vertices, shape=(3, 4, 5))
        shift = np.array([10.0, -20.0, 30.0])
        moved = lattice.bind(vertices, device="cpu").deform(lattice.rest + shift)
        np.testing.assert_allclose(moved, vertices + shift, rtol=0, atol=1e-11)


def test_a_flat_cloud_gets_a_lattice_that_can_move_it():
    plane = np.random.default_rng(0).random((30, 3)) * [5, 2, 0]
    lattice = isochor.Lattice.around(plane, shape=(4, 4, 4))
    binding = lattice.bind(plane)
    np.testing.assert_allclose(binding.deform(lattice.rest), plane, rtol=0, atol=1e-14)
    lifted = binding.deform(lattice.rest + [0, 0, 1.0] * np.square(lattice.rest[..., :1]))
    assert np.ptp(lifted[:, 2]) > 1


def test_margin_leaves_room_on_every_side():
    vertices = meshes.icosphere(2)[0]
    parameters = isochor.Lattice.around(vertices, shape=(4, 4, 4), margin=0.1).parameters(vertices)
    assert parameters.min() > 0.01
    assert parameters.max() < 0.99
    np.testing.assert_allclose(parameters.min(axis=0), 1 - parameters.max(axis=0), atol=1e-12)


def test_points_without_triangles_deform():
    """Planes, curves and clouds: any points."""
    spec = Spec()
    curve = np.linspace([0, 0.2, 0.4], [1, 0.9, 0.5], 30)
    control = lattices.noisy(spec)
    for points in (curve, curve[:1], curve * [1, 1, 0]):
        expected = Embedded.of(spec, points, np.zeros((0, 3), int)).deform(control)
        np.testing.assert_allclose(spec.build().bind(points).deform(control), expected, rtol=0, atol=1e-14)


def test_devices_are_listed_and_the_cpu_is_among_them():
    found = isochor.devices()
    assert found
    assert {device.kind for device in found} <= {"gpu", "software", "cpu"}
    assert "cpu" in {device.kind for device in found}
    assert all(device.name and isinstance(device.backend, str) for device in found)
