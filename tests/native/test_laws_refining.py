# SPDX-License-Identifier: GPL-3.0-or-later
"""More control points and the same map: degree raised, knots inserted; and derivatives, and poses blended."""

import isochor
import lattices
import laws_exact as exact
import numpy as np
import pytest
from determinants import slopes
from isochor import LatticeError
from laws_deforming import EVERY, POLYNOMIAL, RATIONAL
from oracle import Array, Spec
from refusals import refused

EPSILON = 2.3e-16
BASIC = {**POLYNOMIAL, **RATIONAL}
BERNSTEIN = {name: spec for name, spec in BASIC.items() if spec.basis == "bernstein"}
LOW = {name: spec for name, spec in BERNSTEIN.items() if max(spec.shape) <= 9}  # a B-spline's degree ends at 8
BSPLINE = {name: spec for name, spec in BASIC.items() if spec.basis == "bspline"}


def parameters(seed: int = 1, count: int = 120) -> Array:
    unit = np.random.default_rng(seed).random((count, 3))
    unit[:8] = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), axis=-1).reshape(-1, 3)
    return unit


def posed(spec: Spec, seed: int = 5) -> Array:
    rest = spec.build().rest
    return rest + np.random.default_rng(seed).uniform(-0.5, 0.5, rest.shape) * np.abs(spec.edges).max()


def check_same(spec: Spec, control: Array, finer, points: Array) -> None:
    """The same map everywhere, the same rest, the same deformed mesh.

    With unequal weights `evaluate` is (14.1) itself, which moves a lattice at rest; what a refinement must keep is what
    meshes get, Σ R (P − P_rest).
    """
    lattice, at = spec.build(), parameters()
    assert points.shape == (*finer.shape, 3)
    assert all(new >= old for new, old in zip(finer.shape, spec.shape))
    room = 4 * spec.rounding(np.abs(control).max() + np.abs(spec.rest).max(), EPSILON)
    if spec.weights is None:
        there = finer.evaluate(at, points)
        np.testing.assert_allclose(there, lattice.evaluate(at, control), rtol=0, atol=room)
        np.testing.assert_allclose(
            finer.evaluate(at, finer.rest), lattice.evaluate(at, lattice.rest), rtol=0, atol=room
        )
    np.testing.assert_allclose(finer.origin, lattice.origin, rtol=0, atol=0)
    np.testing.assert_allclose(finer.edges, lattice.edges, rtol=0, atol=0)
    mesh = np.concatenate([lattices.points_inside(spec), 2 * lattices.points_inside(spec)])
    for outside in ("keep", "extend"):
        here, there = (x.bind(mesh, outside=outside).deform(c) for x, c in ((lattice, control), (finer, points)))
        np.testing.assert_allclose(there, here, rtol=0, atol=room)


@pytest.mark.parametrize("spec", BERNSTEIN.values(), ids=BERNSTEIN)
def test_degree_elevation_changes_nothing(spec):
    control = posed(spec)
    shape = tuple(n + extra if n > 1 else 1 for n, extra in zip(spec.shape, (1, 3, 2)))
    finer, points = spec.build().refine(control, shape=shape)
    assert (finer.shape, finer.basis) == (shape, "bernstein")
    check_same(spec, control, finer, points)


@pytest.mark.parametrize("spec", BSPLINE.values(), ids=BSPLINE)
def test_more_points_change_nothing(spec):
    control = posed(spec)
    shape = tuple(n + extra for n, extra in zip(spec.shape, (1, 7, 3)))
    finer, points = spec.build().refine(control, shape=shape)
    assert finer.shape == shape
    assert finer.degree == spec.build().degree
    check_same(spec, control, finer, points)


@pytest.mark.parametrize("spec", BSPLINE.values(), ids=BSPLINE)
def test_knots_inserted_change_nothing_and_are_there(spec):
    """Several at once, one of them twice, one where a knot is already."""
    control, lattice = posed(spec), spec.build()
    inserted = ([0.3, 0.7, 0.3], None, [0.123456, 0.25])
    finer, points = lattice.refine(control, insert=inserted)
    assert finer.shape == tuple(np.add(spec.shape, (3, 0, 2)).tolist())
    check_same(spec, control, finer, points)
    for axis, new in enumerate(inserted):
        expected = np.sort(np.concatenate([lattice.knots[axis], new or []]))
        np.testing.assert_allclose(finer.knots[axis], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("spec", LOW.values(), ids=LOW)
def test_knots_inserted_into_bernstein_make_it_a_bspline(spec):
    control = posed(spec)
    finer, points = spec.build().refine(control, insert=([0.25], [0.5] if spec.shape[1] > 1 else None, None))
    assert finer.basis == "bspline"
    check_same(spec, control, finer, points)


@pytest.mark.parametrize("degree", [4, (3, 5, 4), (8, 3, 3)], ids=str)
@pytest.mark.parametrize("name", ["uniform", "knots", "oblique", "rational-uniform", "rational-knots"])
def test_a_raised_degree_changes_nothing(name, degree):
    spec = BSPLINE[name]
    control = posed(spec)
    finer, points = spec.build().refine(control, degree=degree)
    assert finer.degree == (degree if isinstance(degree, tuple) else (degree,) * 3)
    check_same(spec, control, finer, points)


@pytest.mark.parametrize("name", ["bernstein", "rational-bernstein"])
def test_raising_bernsteins_degree_by_its_number(name):
    spec = BERNSTEIN[name]
    control = posed(spec)
    finer, points = spec.build().refine(control, degree=(5, 3, 20))
    assert finer.shape == (6, 4, 21)
    check_same(spec, control, finer, points)


@pytest.mark.parametrize("name", ["bernstein", "uniform", "knots", "rational-bernstein", "rational-uniform"])
def test_refining_twice_is_refining_once_and_shape_keys_go_along(name):
    spec = BASIC[name]
    keys = np.stack([posed(spec, seed) for seed in range(4)])
    lattice = spec.build()
    shape = tuple(n + 2 for n in spec.shape)
    finer, all_keys = lattice.refine(keys, shape=shape)
    assert all_keys.shape == (4, *shape, 3)
    for key, refined in zip(keys, all_keys):
        alone, points = lattice.refine(key, shape=shape)
        np.testing.assert_array_equal(points, refined)
        np.testing.assert_array_equal(alone.rest, finer.rest)
    finest, points = finer.refine(all_keys[0], shape=tuple(n + 3 for n in shape))
    check_same(spec, keys[0], finest, points)


@pytest.mark.parametrize("name", ["bernstein", "uniform", "knots", "rational-bernstein", "rational-knots"])
def test_rest_is_refined_to_rest(name):
    """A refined lattice at rest is the identity, so its rest is the refined rest wherever rest has linear precision."""
    spec = BASIC[name]
    lattice = spec.build()
    finer, points = lattice.refine(lattice.rest, shape=tuple(n + 2 for n in spec.shape))
    if spec.weights is None:
        np.testing.assert_allclose(points, finer.rest, rtol=0, atol=1e-13)
    else:
        assert finer.weights is not None
        assert np.all(finer.weights > 0)
        assert finer.weights.shape == finer.shape
    mesh = lattices.points_inside(spec)
    np.testing.assert_allclose(finer.bind(mesh).deform(points), mesh, rtol=0, atol=1e-13)


def test_inserted_knots_against_exact_fractions():
    """One knot into a clamped cubic: Boehm's convex combinations, in exact numbers."""
    spec = Spec((6, 2, 2), "bspline", (3, 1, 1), "clamped")
    control = posed(spec)
    finer, points = spec.build().refine(control, insert=([0.5], None, None))
    knots = exact.knots(spec, 0)
    new = exact.Fraction(1, 2)
    for j, k, x in np.ndindex(2, 2, 3):
        old = exact.fractions(control[:, j, k, x])
        expected = []
        for i in range(7):
            below = exact.Fraction(1) if i == 0 else None
            span = knots[min(i + 3, len(knots) - 1)] - knots[i]
            share = min(max((new - knots[i]) / span, 0), 1) if span else below or exact.Fraction(int(new > knots[i]))
            first = old[i] if i < 6 else exact.Fraction(0)
            second = old[i - 1] if i else exact.Fraction(0)
            expected.append(float(share * first + (1 - share) * second))
        np.testing.assert_allclose(points[:, j, k, x], expected, rtol=0, atol=8 * EPSILON)
    assert finer.shape == (7, 2, 2)


@pytest.mark.parametrize("spec", BASIC.values(), ids=BASIC)
def test_knots_are_those_of_the_domain(spec):
    """Non-decreasing, points + degree + 1 of them, the domain [0, 1] at its place; and a lattice made of them is it."""
    lattice = spec.build()
    for axis, knots in enumerate(lattice.knots):
        count, degree = spec.shape[axis], lattice.degree[axis]
        if count == 1:
            continue
        assert len(knots) == count + degree + 1
        assert np.all(np.diff(knots) >= 0)
        assert knots[degree] == 0
        assert knots[count] == 1
        if spec.basis == "bspline":
            np.testing.assert_allclose(knots, [float(k) for k in exact.knots(spec, axis)], rtol=0, atol=4e-16 * 4)
    if min(spec.shape) > 1 and max(lattice.degree) <= 8:
        again = isochor.Lattice(
            shape=spec.shape, basis="bspline", degree=lattice.degree, knots=tuple(lattice.knots),
            origin=spec.origin, edges=spec.edges, weights=spec.weights,
        )  # fmt: skip
        control, at = posed(spec), parameters(3)
        room = spec.rounding(np.abs(control).max() + np.abs(spec.rest).max(), EPSILON)
        np.testing.assert_allclose(again.evaluate(at, control), lattice.evaluate(at, control), rtol=0, atol=room)


@pytest.mark.parametrize("name", ["uniform", "bernstein"])
def test_what_refining_cannot_do_is_refused(name):
    lattice = BASIC[name].build()
    rest = lattice.rest
    with refused(LatticeError, "shape"):
        lattice.refine(rest, shape=tuple(n - 1 for n in lattice.shape))
    with refused(LatticeError, "degree"):
        lattice.refine(rest, degree=1)
    for insert in (([0.0], None, None), ([1.0], None, None), ([np.nan], None, None), ([2.0], None, None)):
        with refused(LatticeError, ("insert", "knot")):
            lattice.refine(rest, insert=insert)


@pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
def test_derivative_is_that_of_the_map(spec):
    """Rows d/ds, d/dt, d/du, by the quotient rule on the textbook's derivatives of the basis."""
    control, at = posed(spec), np.random.default_rng(2).uniform(0.01, 0.99, (80, 3))
    found = spec.build().derivative(at, control)
    assert (found.dtype, found.shape) == (np.float64, (80, 3, 3))
    expected = derivative(spec, at, control)
    size = np.abs(control).max() + np.abs(spec.rest).max()
    room = 40 * max(spec.shape) * spec.rounding(size, EPSILON)
    np.testing.assert_allclose(found, expected, rtol=0, atol=room)


def derivative(spec: Spec, at: Array, control: Array) -> Array:
    """(V, 3, 3) of x0 + Σ R (P − P_rest), of which d x0 is the frame's edges; with weights of Σ R P, as `evaluate`.

    Along an axis with one point a lattice keeps its edge.
    """
    moved = (control - spec.build().rest).reshape(-1, 3)
    edges = np.asarray(spec.edges, dtype=float)
    if spec.weights is not None:
        moved, edges = control.reshape(-1, 3), edges * (np.array(spec.shape) == 1)[:, None]
    heavy = np.ones(spec.shape) if spec.weights is None else np.asarray(spec.weights)
    values = [spec.axis_weights(axis, at[:, axis]) for axis in range(3)]
    rows = np.einsum("vi,vj,vk,ijk->vijk", *values, heavy).reshape(len(at), -1)
    total = rows.sum(axis=1, keepdims=True)
    found = np.zeros((len(at), 3, 3))
    for axis in range(3):
        factors = list(values)
        factors[axis] = axis_slopes(spec, axis, at[:, axis])
        slope = np.einsum("vi,vj,vk,ijk->vijk", *factors, heavy).reshape(len(at), -1)
        rational = slope / total - rows * slope.sum(axis=1, keepdims=True) / total**2
        found[:, axis] = edges[axis] + rational @ moved
    return found


@pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
def test_derivative_is_that_of_evaluate_inside_and_outside(spec):
    """By central differences of evaluate, wherever it is asked."""
    control, at = posed(spec), np.random.default_rng(3).uniform(-0.7, 1.7, (60, 3))
    lattice, step = spec.build(), 1e-6
    slope = [
        (lattice.evaluate(at + step * unit, control) - lattice.evaluate(at - step * unit, control)) / (2 * step)
        for unit in np.eye(3)
    ]
    size = np.abs(control).max() * max(spec.shape) ** 3
    np.testing.assert_allclose(lattice.derivative(at, control), np.stack(slope, axis=1), rtol=0, atol=1e-7 * size)


def axis_slopes(spec: Spec, axis: int, t: Array) -> Array:
    """(V, n) derivatives of an axis' functions; Blender's by the derivative of each cell's cubic, fitted exactly."""
    if spec.basis != "blender" or spec.shape[axis] == 1:
        return slopes(spec, axis, t)
    count, nodes = spec.shape[axis], (np.arange(4) + 0.5) / 4
    cell = np.floor(t * (count - 1))
    places = (cell[:, None] + nodes) / (count - 1)
    values = spec.axis_weights(axis, places.ravel()).reshape(len(t), 4, count)
    across = t * (count - 1) - cell
    powers = np.stack([np.zeros_like(across), np.ones_like(across), 2 * across, 3 * across**2], axis=1)
    return np.einsum("vp,pm,vmn->vn", powers, np.linalg.inv(np.vander(nodes, increasing=True)), values) * (count - 1)


@pytest.mark.parametrize("name", ["bernstein", "uniform", "rational-mixed", "blender-mixed"])
def test_blending_is_relative_to_rest(name):
    spec = EVERY[name]
    lattice = spec.build()
    sets = np.stack([posed(spec, seed) for seed in range(5)])
    weights = np.array([0.5, -0.25, 2.0, 0.0, 1e-3])
    expected = lattice.rest + np.einsum("k,kijlx->ijlx", weights, sets - lattice.rest)
    blended = lattice.blend(sets, weights)
    assert (blended.dtype, blended.shape) == (np.float64, lattice.rest.shape)
    np.testing.assert_allclose(blended, expected, rtol=0, atol=1e-14 * np.abs(sets).max() * 4)


def test_blending_one_pose_is_it_and_none_is_rest():
    """Ferrier's interpolation between two sets of control points: the ends to the bit, the middle in the middle."""
    lattice = EVERY["uniform"].build()
    sets = np.stack([posed(EVERY["uniform"], seed) for seed in range(2)])
    np.testing.assert_array_equal(lattice.blend(sets, [0, 0]), lattice.rest)
    np.testing.assert_allclose(lattice.blend(sets, [1, 0]), sets[0], rtol=0, atol=4e-16 * 4)
    np.testing.assert_allclose(lattice.blend(sets, [0.5, 0.5]), sets.mean(axis=0), rtol=0, atol=4e-16 * 4)
    at = parameters()
    for t in np.linspace(0, 1, 5):
        there = lattice.evaluate(at, lattice.blend(sets, [1 - t, t]))
        ends = [lattice.evaluate(at, pose) for pose in sets]
        np.testing.assert_allclose(there, (1 - t) * ends[0] + t * ends[1], rtol=0, atol=1e-14)
    assert lattice.blend(np.zeros((0, *lattice.rest.shape)), []).shape == lattice.rest.shape
