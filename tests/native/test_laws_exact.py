# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluation against exact fractions: a few units in the last place of the size, at every degree that there is."""

from dataclasses import replace

import laws_exact as exact
import numpy as np
import pytest
from oracle import Array, Spec

ULPS = 8  # of the largest control value: what a sum over the lattice may round
EPSILON = 2.0**-52
BSPLINE = Spec((9, 6, 5), "bspline", 3, "uniform")


def places(seed: int, count: int = 5) -> Array:
    """Corners, an edge, and parameters at random, some all but on a face."""
    random = np.random.default_rng(seed)
    inside = random.random((count, 3))
    near = np.where(random.random((2, 3)) < 0.5, 1e-12, 1 - 2.0**-53)
    return np.concatenate([[[0, 0, 0], [1, 1, 1], [0, 1, 0.5]], near, inside])


def control(spec: Spec, seed: int = 4) -> Array:
    """Values in [−1, 1], all signs side by side: what oscillates most."""
    return np.random.default_rng(seed).uniform(-1, 1, (*spec.shape, 3))


def blended(spec: Spec, parameters: Array, values: Array) -> Array:
    """Σ B values as the library has it, whatever it adds to make rest the identity."""
    lattice = spec.build()
    return lattice.evaluate(parameters, values) - lattice.evaluate(parameters, np.zeros_like(values))


def check(spec: Spec, ulps: float = ULPS) -> None:
    values, parameters = control(spec), places(sum(spec.shape))
    off = np.abs(blended(spec, parameters, values) - exact.blends(spec, parameters, values)).max()
    assert off <= ulps * EPSILON, f"off by {off / EPSILON:.1f} units in the last place"


def degrees(degree: int, axis: int) -> tuple[int, ...]:
    """Points of a lattice of that degree along one axis and of others along the rest: m × n × o."""
    return tuple(np.roll([degree + 1, 3, 2], axis).tolist())


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("degree", [1, 2, 3, 7, 12, 20, 25, 40, 63])
def test_bernstein_of_any_degree_along_any_axis(degree, axis):
    check(Spec(degrees(degree, axis)))


def test_bernstein_of_high_degree_along_all_axes_at_once():
    spec = Spec((26, 5, 21))
    values, parameters = control(spec), places(1, 1)[3:]
    off = np.abs(blended(spec, parameters, values) - exact.blends(spec, parameters, values)).max()
    assert off <= ULPS * EPSILON


@pytest.mark.parametrize("knots", ["uniform", "clamped"])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
def test_bsplines(degree, axis, knots):
    points = np.roll([degree + 8, 6, 4], axis)
    order = np.roll([degree, 2, 3], axis)
    spec = Spec(tuple(points.tolist()), "bspline", tuple(order.tolist()), knots)
    check(spec, 16)  # parameters and knots that are rounded themselves, on as steep a basis


def test_any_knots():
    uneven = (-0.75, -0.25, -0.125, 0, 0.1875, 0.1875, 0.875, 1, 1.5, 1.5, 2.5)
    tripled = (0, 0, 0, 0, 0.3125, 0.3125, 0.3125, 1, 1, 1, 1)
    check(Spec((7, 7, 7), "bspline", 3, (uneven, tripled, uneven)), 16)


@pytest.mark.parametrize("spread", [1, 1e3, 1e6])
@pytest.mark.parametrize("name", ["bernstein-20", "bernstein", "bspline"])
def test_rational_of_any_weights(name, spread):
    spec = {"bernstein-20": Spec((21, 3, 2)), "bernstein": Spec((4, 5, 6)), "bspline": BSPLINE}[name]
    spec = replace(spec, weights=spread ** np.random.default_rng(3).uniform(-0.5, 0.5, spec.shape))
    check(spec)
    values, parameters = control(spec), places(5)
    plain = exact.blends(spec, parameters, values)  # (14.1), nothing added
    found = spec.build().evaluate(parameters, values)
    np.testing.assert_allclose(found, plain, rtol=0, atol=ULPS * EPSILON if spread > 1 else np.inf)


@pytest.mark.parametrize("spec", [Spec((21, 3, 6)), BSPLINE], ids=["bernstein", "bspline"])
def test_derivatives(spec):
    """Of Bernstein by differences of degree one less; of B-splines by exact divided differences of the polynomial."""
    values, parameters = control(spec), np.random.default_rng(2).random((4, 3))
    found = spec.build().derivative(parameters, values)
    assert found.shape == (4, 3, 3)
    for place, rows in zip(parameters, found):
        for axis in range(3):
            expected = exact_slope(spec, place, axis, values)
            steepest = 2 * spec.axis_degree(axis) * spec.shape[axis]
            np.testing.assert_allclose(rows[axis], expected, rtol=0, atol=ULPS * steepest * EPSILON)


def exact_slope(spec: Spec, place: Array, axis: int, values: Array) -> list[float]:
    """Exact derivative of the polynomial piece: by a symmetric difference with a step that exact numbers can take."""
    step = exact.Fraction(1, 2**200)
    t = exact.Fraction(float(place[axis]))
    others = [exact.axis(spec, a, exact.Fraction(float(place[a]))) for a in range(3)]
    ahead, behind = (exact.axis(spec, axis, t + side * step) for side in (1, -1))
    others[axis] = [(a - b) / (2 * step) for a, b in zip(ahead, behind)]
    totals = [exact.Fraction(0)] * 3
    for i, j, k in np.ndindex(*spec.shape):
        weight = others[0][i] * others[1][j] * others[2][k]
        if weight:
            totals = [total + weight * exact.Fraction(float(v)) for total, v in zip(totals, values[i, j, k])]
    return [float(total) for total in totals]


def test_refined_lattices_are_exact_too():
    """A cubic raised to degree 25: its control points, and what they give, against exact degree elevation."""
    spec = Spec((4, 3, 2))
    values = control(spec)
    finer, points = spec.build().refine(values, shape=(26, 3, 2))
    assert finer.shape == (26, 3, 2)
    for j, k, x in np.ndindex(3, 2, 3):
        column = exact.fractions(values[:, j, k, x])
        while len(column) < 26:
            column = exact.elevated(column)
        np.testing.assert_allclose(points[:, j, k, x], [float(value) for value in column], rtol=0, atol=ULPS * EPSILON)
    parameters = places(9)
    expected = exact.blends(spec, parameters, values)
    np.testing.assert_allclose(finer.evaluate(parameters, points), expected, rtol=0, atol=2 * ULPS * EPSILON)
