# SPDX-License-Identifier: GPL-3.0-or-later
"""The determinant of a lattice map's derivative, by the textbook's derivative of a B-spline and dense sums."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from oracle import Array, Spec, bernstein, cox_de_boor


def determinants(spec: Spec, control: ArrayLike, parameters: ArrayLike) -> Array:
    """(V,) det J at parameters (V, 3), in units of the frame's determinant: 1 at rest."""
    parameters = np.asarray(parameters, dtype=float)
    moved = np.asarray(control, dtype=float) - spec.rest
    values = [spec.axis_weights(axis, parameters[:, axis]) for axis in range(3)]
    edges = np.asarray(spec.edges, dtype=float)
    columns = []
    for axis in range(3):
        u, v, w = (slopes(spec, a, parameters[:, a]) if a == axis else values[a] for a in range(3))
        columns.append(edges[axis] + np.einsum("vi,vj,vk,ijkx->vx", u, v, w, moved, optimize=True))
    return np.linalg.det(np.stack(columns, axis=-1)) / np.linalg.det(edges.T)


def slopes(spec: Spec, axis: int, t: Array) -> Array:
    """(V, n) derivatives of the n basis functions of one axis: d times differences of those of degree d - 1."""
    count, degree = spec.shape[axis], spec.axis_degree(axis)
    if count == 1:
        return np.zeros((len(t), 1))
    if spec.basis == "bernstein":
        lower, lengths = bernstein(degree - 1, t), np.ones(count - 1)
    else:
        knots = spec.knot_vector(axis)
        lower, lengths = cox_de_boor(knots[1:-1], degree - 1, t), knots[degree + 1 : -1] - knots[1 : -degree - 1]
    rates = degree * lower / np.where(lengths > 0, lengths, np.inf)
    return np.pad(rates, ((0, 0), (1, 0))) - np.pad(rates, ((0, 0), (0, 1)))


def grid(count: int = 9, margin: float = 0.0) -> Array:
    """(count³, 3) parameters evenly over the domain, its faces included but for `margin`."""
    steps = np.linspace(margin, 1 - margin, count)
    return np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
