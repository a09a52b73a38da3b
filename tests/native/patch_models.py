# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed model of Bézier patches for the tests, and de Casteljau's scheme."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def urn(degree: int = 3, seed: int = 4) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Control points (K, 3), patches (8, degree + 1, degree + 1) of a closed body in [0, 1]^3, collapsed at both poles.

    Every other patch runs up instead of down, so that neighbours are wound against each other.
    """
    random = np.random.default_rng(seed)
    around, down = 4 * degree, 2 * degree
    rings = []
    for r in range(1, down):
        height, angle = 1 - 2 * r / down, 2 * np.pi * np.arange(around) / around
        radius = 0.5 + 0.4 * np.sqrt(1 - height**2) + 0.05 * random.random(around)
        rings.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(around, height)], axis=1))
    points = np.concatenate([[[0.0, 0.1, 1.0]], *rings, [[0.1, 0.0, -1.0]]])
    last = len(points) - 1

    def at(r: int, k: int) -> int:
        return 0 if r == 0 else last if r == down else 1 + (r - 1) * around + k % around

    patches = []
    for row in range(2):
        for sector in range(4):
            rows = range(degree + 1) if (row + sector) % 2 else range(degree, -1, -1)
            patches.append([[at(row * degree + i, sector * degree + j) for j in range(degree + 1)] for i in rows])
    return 0.5 + 0.4 * points, np.array(patches, dtype=np.int32)


def casteljau(points: NDArray[np.float64], u: float, v: float) -> NDArray[np.float64]:
    """Place at (u, v) of a patch (m, n, 3)."""
    for t in (u, v):
        while len(points) > 1:
            points = (1 - t) * points[:-1] + t * points[1:]
        points = points[0]
    return points
