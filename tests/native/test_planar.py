# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices of the plane: points that follow, areas that stay; and lattices of one axis."""

import isochor
import numpy as np
import pytest
from isochor import Lattice, Lattice2D, LatticeError, MeshError, PinError, VolumeError
from refusals import refused

EDGES = ((3.0, 0.4), (-0.5, 2.0))
ORIGIN = (-0.3, 0.2)
LATTICES = {
    "bernstein": {"shape": (4, 3)},
    "uniform": {"shape": (6, 5), "basis": "bspline", "degree": (3, 2)},
    "clamped": {"shape": (7, 6), "basis": "bspline", "knots": "clamped"},
    "arrays": {"shape": (3, 4), "basis": "bspline", "degree": 2, "knots": ([0, 0, 0, 1, 1, 2], [0, 1, 2, 3, 4, 5, 9])},
    "one row": {"shape": (5, 1)},
}
METHODS = ("balanced", "sweep", "gradient", "nearest")
each_lattice = pytest.mark.parametrize("kind", LATTICES.values(), ids=LATTICES)


def build(kind):
    return Lattice2D(**kind, origin=ORIGIN, edges=EDGES)


def grid(n=8, hole=lambda i, j: False):
    """A grid of squares inside the lattice, those left out for which `hole` says so."""
    s, t = np.meshgrid(np.linspace(0.1, 0.9, n + 1), np.linspace(0.1, 0.9, n + 1), indexing="ij")
    vertices = np.stack([s.ravel(), t.ravel()], axis=1) @ EDGES + ORIGIN
    squares = [(i, j) for i in range(n) for j in range(n) if not hole(i, j)]
    corners = [[(i + a) * (n + 1) + j + b for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))] for i, j in squares]
    return vertices, np.array([t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))])


MESHES = {
    "whole": grid(),
    "two holes": grid(9, lambda i, j: (i, j) == (4, 4) or (1 <= i < 3 and j == 2)),
    "corners that touch": grid(6, lambda i, j: (i + j) % 2 == 0),
    "two parts": grid(7, lambda i, j: i == 3),
}


def shoelace(vertices, triangles):
    a, b, c = np.moveaxis(vertices.astype(np.longdouble)[triangles], 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return float(np.sum(ux * vy - uy * vx) / 2)


def bent(lattice, amount=0.3, seed=4):
    return lattice.rest + amount * np.random.default_rng(seed).uniform(-1, 1, lattice.rest.shape)


@each_lattice
def test_rest_is_the_identity_and_parameters_go_there_and_back(kind):
    lattice = build(kind)
    vertices, triangles = grid()
    assert lattice.rest.shape == (*lattice.shape, 2)
    assert np.array_equal(lattice.bind(vertices, triangles, device="cpu").deform(lattice.rest), vertices)
    parameters = lattice.parameters(vertices)
    np.testing.assert_allclose(parameters @ lattice.edges + lattice.origin, vertices, atol=1e-14)
    control = bent(lattice)
    expected = lattice.bind(vertices, device="cpu").deform(control)
    np.testing.assert_allclose(lattice.evaluate(parameters, control), expected, atol=1e-14)


@each_lattice
def test_the_plane_is_one_layer_of_space(kind):
    lattice = build(kind)
    count, knots = lattice.shape, (*lattice.knots, [0.0, 1.0])
    edges = [(*EDGES[0], 0), (*EDGES[1], 0), (0, 0, 1)]
    degree = (*(max(d, 1) for d in lattice.degree), 1)
    space = Lattice((*count, 1), "bspline", degree, knots, (*ORIGIN, 0), edges)
    vertices, _ = grid()
    control = bent(lattice)
    lifted = np.concatenate([control, np.full((*count, 1), 0.5)], axis=2)[:, :, None]
    expected = space.bind(np.pad(vertices, ((0, 0), (0, 1))), device="cpu").deform(lifted)
    np.testing.assert_allclose(lattice.bind(vertices, device="cpu").deform(control), expected[:, :2], atol=1e-14)


@each_lattice
@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("method", METHODS)
def test_the_area_is_kept(kind, mesh, method):
    vertices, triangles = mesh
    lattice = build(kind)
    binding = lattice.bind(vertices, triangles, device="cpu")
    area = shoelace(vertices, triangles)
    assert binding.reference_area == pytest.approx(area, rel=1e-13)
    for axes in (None, (1, 0), (0, 1), (0.3, 0.7)):
        result = binding.preserve(bent(lattice), axes=axes, method=method)
        assert shoelace(result.vertices, triangles) == pytest.approx(area, rel=1e-12)
        assert result.error < 1e-12
        assert result.area == pytest.approx(area, rel=1e-12)
        np.testing.assert_allclose(binding.deform(result.control), result.vertices, atol=1e-14)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("size", [1e-4, 1.0, 3e4])
def test_in_both_precisions_and_at_any_size(dtype, size):
    vertices, triangles = grid(20)
    lattice = Lattice2D((5, 5), origin=np.array(ORIGIN) * size, edges=np.array(EDGES) * size)
    points = (vertices * size).astype(dtype)
    result = lattice.bind(points, triangles, device="cpu").preserve(bent(lattice, 0.3 * size))
    assert result.vertices.dtype == dtype
    tolerance = 1e-12 if dtype == np.float64 else 1e-6
    assert shoelace(result.vertices, triangles) == pytest.approx(shoelace(points, triangles), rel=tolerance)


def test_the_tripwire_area_changes_without_correction():
    vertices, triangles = grid()
    lattice = build(LATTICES["bernstein"])
    binding = lattice.bind(vertices, triangles, device="cpu")
    squashed = lattice.rest * (1, 0.5)
    assert binding.area(squashed) == pytest.approx(0.5 * binding.reference_area, rel=1e-12)
    assert binding.preserve(squashed, amount=0).area == pytest.approx(0.5 * binding.reference_area, rel=1e-12)
    half = binding.preserve(squashed, target=0.8 * binding.reference_area)
    assert half.area == pytest.approx(0.8 * binding.reference_area, rel=1e-12)


def test_weights_and_pins():
    vertices, triangles = grid()
    lattice = build(LATTICES["bernstein"])
    binding = lattice.bind(vertices, triangles, device="cpu")
    weights = np.ones(lattice.shape)
    weights[0] = np.inf
    control = bent(lattice)
    result = binding.preserve(control, weights=weights)
    assert np.array_equal(result.control[0], control[0])
    assert result.error < 1e-12
    target = vertices[[10, 40]] + (0.1, -0.05)
    pinned = binding.preserve(control, pins=([10, 40], target))
    np.testing.assert_allclose(pinned.vertices[[10, 40]], target, atol=1e-13)
    assert shoelace(pinned.vertices, triangles) == pytest.approx(shoelace(vertices, triangles), rel=1e-12)


def test_a_rational_plane_draws_an_exact_circle_and_keeps_its_area():
    quarter = Lattice2D((3, 2), weights=[(1, 1), (0.5**0.5, 0.5**0.5), (1, 1)])
    assert quarter.weights.shape == (3, 2)
    arc = np.array([[(r, 0), (r, r), (0, r)] for r in (1.0, 2.0)]).transpose(1, 0, 2)
    parameters = np.random.default_rng(3).random((100, 2))
    radii = np.linalg.norm(quarter.evaluate(parameters, arc), axis=1)
    np.testing.assert_allclose(radii, 1 + parameters[:, 1], rtol=0, atol=1e-15)
    vertices, triangles = grid()
    rational = Lattice2D((4, 4), origin=ORIGIN, edges=EDGES, weights=np.random.default_rng(2).uniform(0.2, 5, (4, 4)))
    binding = rational.bind(vertices, triangles, device="cpu")
    assert np.array_equal(binding.deform(rational.rest), vertices)
    result = binding.preserve(bent(rational))
    assert shoelace(result.vertices, triangles) == pytest.approx(shoelace(vertices, triangles), rel=1e-12)


def test_points_outside_stay_or_follow():
    lattice = build(LATTICES["bernstein"])
    points = np.array([(0.5, 0.9), (-5, 0), (9, 9)], dtype=float)
    moved = lattice.rest + (1, 0)
    kept = lattice.bind(points, device="cpu").deform(moved)
    np.testing.assert_allclose(kept - points, [(1, 0), (0, 0), (0, 0)], atol=1e-14)
    followed = lattice.bind(points, device="cpu", outside="extend").deform(moved)
    np.testing.assert_allclose(followed - points, [(1, 0)] * 3, atol=1e-14)


def test_on_every_device_the_same_area():
    vertices, triangles = grid(30)
    lattice = build(LATTICES["clamped"])
    for device in ("cpu", "auto"):
        assert lattice.bind(vertices, triangles, device=device).preserve(bent(lattice)).error < 1e-12


def test_one_axis_in_space_bends_only_along_itself():
    """1D: a lattice of space with one control point on two axes; Bernstein's polynomials by their formula."""
    line = Lattice((4, 1, 1))
    control = line.rest + np.array([(0, 0, 0), (0, 0, 1), (0, 0, -2), (0, 0, 0.5)])[:, None, None]
    points = np.random.default_rng(1).random((50, 3))
    moved = line.bind(points, device="cpu").deform(control)
    s = points[:, 0]
    height = 3 * s * (1 - s) ** 2 - 2 * 3 * s**2 * (1 - s) + 0.5 * s**3
    np.testing.assert_allclose(moved - points, np.outer(height, (0, 0, 1)), atol=1e-15)
    plane = Lattice2D((4, 1))
    flat = plane.rest + np.array([(0, 0), (0, 1), (0, -2), (0, 0.5)])[:, None]
    moved = plane.bind(points[:, :2], device="cpu").deform(flat)
    np.testing.assert_allclose(moved - points[:, :2], np.outer(height, (0, 1)), atol=1e-15)


def test_what_is_no_lattice_or_flat_mesh():
    with refused(LatticeError, "shape"):
        Lattice2D((4, 4, 4))
    with refused(LatticeError, "knots", "two arrays"):
        Lattice2D((4, 4), "bspline", knots=([0, 1], [0, 1], [0, 1]))
    with refused(LatticeError, "on one line"):
        Lattice2D(edges=[(1, 0), (2, 0)])
    with refused(LatticeError, "control", "shape"):
        Lattice2D().evaluate([(0, 0)], np.zeros((4, 4, 3)))
    vertices, triangles = grid()
    with refused(MeshError, "vertices", "shape"):
        Lattice2D().bind(np.pad(vertices, ((0, 0), (0, 1))))
    with refused(MeshError, "edge", "once in each direction"):
        Lattice2D().bind(vertices, np.concatenate([triangles, triangles[:1]]))
    with refused(MeshError, "out of range"):
        Lattice2D().bind(vertices, triangles + 9)
    bound = Lattice2D(origin=ORIGIN, edges=EDGES).bind(vertices, triangles, device="cpu")
    frozen = np.full((4, 4), np.inf)
    with refused(VolumeError, "area", "cannot be reached"):
        bound.preserve(Lattice2D(origin=ORIGIN, edges=EDGES).rest * (1, 0.5), weights=frozen)
    with refused(PinError, "pins"):
        bound.preserve(Lattice2D(origin=ORIGIN, edges=EDGES).rest, pins=([-1], [(0, 0)]))
    with refused(MeshError, "triangles"):
        _ = Lattice2D().bind(vertices).reference_area
    assert isinstance(isochor.Lattice2D(), Lattice2D)
