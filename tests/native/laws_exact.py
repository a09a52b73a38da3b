# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices in exact rational arithmetic: floats are the fractions that they are, and only the end is rounded."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from math import comb

import numpy as np
from numpy.typing import ArrayLike
from oracle import Array, Spec

Row = list[Fraction]


def fractions(values: ArrayLike) -> Row:
    """Each float of an array as a fraction."""
    return [Fraction(float(value)) for value in np.ravel(np.asarray(values, dtype=float))]


def bernstein(degree: int, t: Fraction) -> Row:
    """Values of the Bernstein polynomials."""
    return [comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)]


def bspline(knots: Row, degree: int, t: Fraction) -> Row:
    """Values of the B-spline basis by the recursion of Cox and de Boor; the domain's last point is in its last span."""
    count = len(knots) - degree - 1
    spans = [i for i in range(degree, count) if knots[i] < knots[i + 1] and knots[i] <= t]
    values = [Fraction(int(i == spans[-1])) for i in range(len(knots) - 1)]
    for p in range(1, degree + 1):
        values = [
            _ratio(t - knots[i], knots[i + p] - knots[i]) * values[i]
            + _ratio(knots[i + p + 1] - t, knots[i + p + 1] - knots[i + 1]) * values[i + 1]
            for i in range(len(values) - 1)
        ]
    return values


def _ratio(above: Fraction, below: Fraction) -> Fraction:
    return above / below if below else Fraction(0)


def knots(spec: Spec, axis: int) -> Row:
    """The knots of an axis over the domain [0, 1]."""
    count, degree = spec.shape[axis], spec.axis_degree(axis)
    if not isinstance(spec.knots, str):
        given = fractions(spec.knots[axis])
        low, high = given[degree], given[count]
        return [(knot - low) / (high - low) for knot in given]
    even = [Fraction(i - degree, count - degree) for i in range(count + degree + 1)]
    return [min(max(knot, Fraction(0)), Fraction(1)) for knot in even] if spec.knots == "clamped" else even


def axis(spec: Spec, number: int, t: Fraction) -> Row:
    """Values of the basis functions of one axis of a Bernstein or B-spline lattice."""
    if spec.shape[number] == 1:
        return [Fraction(1)]
    if spec.basis == "bernstein":
        return bernstein(spec.shape[number] - 1, t)
    return bspline(knots(spec, number), spec.axis_degree(number), t)


def blend(spec: Spec, parameters: Sequence[float], values: ArrayLike) -> Row:
    """Σ B values, rational ones Σ w B values / Σ w B, at one place: values (nu, nv, nw, m) give m numbers."""
    u, v, w = (axis(spec, a, Fraction(float(parameters[a]))) for a in range(3))
    field = np.asarray(values, dtype=float)
    heavy = np.ones(spec.shape) if spec.weights is None else np.asarray(spec.weights, dtype=float)
    above, below = [Fraction(0)] * field.shape[-1], Fraction(0)
    for i, j, k in np.ndindex(*spec.shape):
        weight = u[i] * v[j] * w[k] * Fraction(float(heavy[i, j, k]))
        if weight:
            below += weight
            above = [total + weight * Fraction(float(value)) for total, value in zip(above, field[i, j, k])]
    return [total / below for total in above]


def blends(spec: Spec, parameters: Array, values: ArrayLike) -> Array:
    """The same at (V, 3) parameters, (V, m), each rounded once."""
    return np.array([[float(number) for number in blend(spec, place, values)] for place in parameters])


def elevated(points: Row) -> Row:
    """Control values of the same polynomial one degree higher."""
    degree = len(points)
    inner = [Fraction(i, degree) * a + (1 - Fraction(i, degree)) * b for i, (a, b) in enumerate(pairwise(points), 1)]
    return [points[0], *inner, points[-1]]
