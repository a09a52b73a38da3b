# SPDX-License-Identifier: GPL-3.0-or-later
"""One-sided derivatives of what a lattice does along a line, measured on deformed points by exact polynomial fits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from oracle import CUBIC, Array, Spec

Along = Callable[[Array], Array]  # parameters (m,) along a line to values (m, 3)


def breaks(spec: Spec, axis: int) -> Array:
    """Parameters in [0, 1] at which one polynomial piece follows another, the ends included."""
    if spec.basis == "blender":
        return np.linspace(0, 1, max(spec.shape[axis], 2))
    if spec.basis == "bernstein" or spec.shape[axis] == 1:
        return np.array([0.0, 1.0])
    knots = spec.knot_vector(axis)
    return np.unique(np.clip(knots, 0, 1))


def continuity(spec: Spec, axis: int, at: float) -> int:
    """Derivatives that agree on both sides of a break: degree less multiplicity; 2, 1 or 0 of Blender's."""
    if spec.basis == "blender":
        word = spec.axis_interpolation(axis)
        return {"bspline": 2, "linear": 0}.get(word, 1)
    multiplicity = int(np.sum(np.abs(spec.knot_vector(axis) - at) < 1e-12))
    return spec.axis_degree(axis) - multiplicity


def piece_degree(spec: Spec, axis: int) -> int:
    """Degree of each polynomial piece along an axis."""
    if spec.basis == "blender" and spec.shape[axis] > 1:
        return 3 if spec.axis_interpolation(axis) in CUBIC else 1
    return spec.axis_degree(axis)


def derivatives(along: Along, start: float, end: float, degree: int, orders: int) -> Array:
    """(orders + 1, 3) derivatives at `start`, from inside, of the polynomial of that degree between start and end."""
    nodes = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    values = along((start + end) / 2 - (end - start) / 2 * nodes)
    series = chebyshev.chebfit(-nodes, values, degree)
    found = []
    for order in range(orders + 1):
        slope = chebyshev.chebder(series, order) if order else series
        found.append(chebyshev.chebval(-1.0, slope) * (2 / (end - start)) ** order)
    return np.array(found)


def rounding(epsilon: float, size: float, degree: int, length: float, order: int) -> float:
    """What rounding of the values leaves of a derivative found so (Markov's inequality)."""
    return 64 * epsilon * size * (2 * max(degree, 1) ** 2 / abs(length)) ** order


def denominator(spec: Spec, parameters: Array) -> Array:
    """(V, 1) Σ w B: with it, what a rational lattice does becomes a polynomial."""
    if spec.weights is None:
        return np.ones((len(parameters), 1))
    u, v, w = (spec.axis_weights(axis, parameters[:, axis]) for axis in range(3))
    return np.einsum("vi,vj,vk,ijk->v", u, v, w, np.asarray(spec.weights, dtype=float))[:, None]
