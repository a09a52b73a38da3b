# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed bodies of Bézier patches that share control points, and their volume by Gauss' quadrature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from oracle import Array, bernstein

KAPPA = 4 / 3 * (2**0.5 - 1)  # a cubic's handles for a quarter of a circle


@dataclass(frozen=True)
class Body:
    """Points (K, 3) and patches (P, m, n) of indices, wound so that du × dv points out."""

    points: Array
    patches: NDArray[np.int64]

    def volume(self, points: Array | None = None) -> float:
        """⅓ Σ ∫ X · (X_u × X_v), exact for polynomial patches."""
        nodes, weights = np.polynomial.legendre.leggauss(12)
        nodes, weights = (nodes + 1) / 2, weights / 2
        total = 0.0
        for net in (self.points if points is None else points)[self.patches]:
            m, n = net.shape[0] - 1, net.shape[1] - 1
            u, v = bernstein(m, nodes), bernstein(n, nodes)
            du, dv = differences(m, nodes), differences(n, nodes)
            place, along_u, along_v = (np.einsum("ai,bj,ijx->abx", p, q, net) for p, q in ((u, v), (du, v), (u, dv)))
            total += float(np.einsum("a,b,ab", weights, weights, np.sum(place * np.cross(along_u, along_v), axis=-1)))
        return total / 3


def differences(degree: int, t: Array) -> Array:
    """(V, degree + 1) derivatives of the Bernstein polynomials."""
    lower = degree * bernstein(degree - 1, t)
    return np.pad(lower, ((0, 0), (1, 0))) - np.pad(lower, ((0, 0), (0, 1)))


def lidded(count: int, bulge: float = 0.08) -> Body:
    """The six faces of a block of count³ control points as patches: shell points shared, bulged at random."""
    grid = np.stack(np.meshgrid(*[np.linspace(0.15, 0.85, count)] * 3, indexing="ij"), axis=-1)
    grid = grid + np.random.default_rng(2).uniform(-bulge, bulge, grid.shape)
    numbers = np.arange(count**3).reshape(count, count, count)
    faces = [numbers[-1], numbers[0].T, numbers[:, -1].T, numbers[:, 0], numbers[:, :, -1], numbers[:, :, 0].T]
    used, renumbered = np.unique(np.stack(faces), return_inverse=True)
    return Body(grid.reshape(-1, 3)[used], renumbered.reshape(6, count, count))


def torus(major: float = 0.28, minor: float = 0.12) -> Body:
    """Four by four bicubic patches about the z axis: a torus to six ten-thousandths of its volume."""
    around, across = _circle(), _circle()
    numbers = np.arange(12 * 12).reshape(12, 12)
    ring = major + minor * across[None, :, :1]
    points = np.concatenate(
        [around[:, None] * ring, np.broadcast_to(minor * across[None, :, 1:], (12, 12, 1))], axis=-1
    ).reshape(-1, 3)
    rows = [[(3 * i + k) % 12 for k in range(4)] for i in range(4)]
    return Body(points + 0.5, np.array([numbers[np.ix_(a, b)] for a in rows for b in rows]))


def _circle() -> Array:
    """(12, 2) control points of four cubics, the joints at 0, 3, 6, 9."""
    quarter = np.array([[1, 0], [1, KAPPA], [KAPPA, 1]])
    turn = np.array([[0, 1], [-1, 0]])
    return np.concatenate([quarter @ np.linalg.matrix_power(turn, k) for k in range(4)])


def lemon(radius: float = 0.3, height: float = 0.4) -> Body:
    """Four bicubic patches between two poles: their first and last rows are one point each."""
    circle = _circle() * radius
    rings = [(np.zeros(2), -height)] + [(circle * s, z) for s, z in ((1.0, -height / 2), (0.8, height / 2))]
    points = [[0, 0, -height]]
    for ring, z in rings[1:]:
        points += [[x, y, z] for x, y in ring]
    points.append([0, 0, height])
    last = len(points) - 1
    patches = []
    for quarter in range(4):
        around = [(3 * quarter + k) % 12 for k in range(4)]
        columns = [[0] * 4, [1 + k for k in around], [13 + k for k in around], [last] * 4]
        patches.append(np.array(columns).T)  # u about the axis, v up: du × dv points out
    return Body(np.array(points) + 0.5, np.array(patches))


def edges_are_shared(triangles: NDArray) -> None:
    """Every half-edge once, its opposite once: closed, manifold, consistently wound."""
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    pairs = set(map(tuple, half.tolist()))
    assert len(pairs) == len(half), "an edge is used twice the same way"
    assert {(b, a) for a, b in pairs} == pairs, "an edge is not shared by two triangles"
    assert not any(a == b for a, b in pairs)
