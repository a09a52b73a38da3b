# SPDX-License-Identifier: GPL-3.0-or-later
"""A square beam of as few faces as may be: long quads, closed (numpy only)."""

import numpy as np

from .model import Array

Quads = tuple[tuple[int, ...], ...]
SIDE, TALL = 0.5, 2.6


def make_beam(storeys: int = 2) -> tuple[Array, Quads]:
    """(4 storeys + 4, 3) points, and quads wound outwards; it stands on z = 0 about the z axis."""
    corners = SIDE / 2.0 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    heights = np.linspace(0.0, TALL, storeys + 1)
    points = np.array([(x, y, z) for z in heights for x, y in corners])
    ring = ((0, 1), (1, 2), (2, 3), (3, 0))
    sides = [(k + a, k + b, k + b + 4, k + a + 4) for k in range(0, 4 * storeys, 4) for a, b in ring]
    top = 4 * storeys
    return points, (*sides, (3, 2, 1, 0), (top, top + 1, top + 2, top + 3))


def divided(points: Array, quads: Quads, parts: int) -> tuple[Array, Quads]:
    """The same surface with every quad cut into parts x parts."""
    steps = np.linspace(0.0, 1.0, parts + 1)
    u, v = np.meshgrid(steps, steps)
    shares = np.stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v], axis=-1).reshape(-1, 4)
    samples = np.einsum("sk,qkc->qsc", shares, points[np.array(quads)]).reshape(-1, 3)
    unique, place = np.unique(samples.round(9), axis=0, return_inverse=True)
    here = place.reshape(-1, parts + 1, parts + 1)
    corners = (here[:, :-1, :-1], here[:, :-1, 1:], here[:, 1:, 1:], here[:, 1:, :-1])
    found = np.stack(corners, axis=-1).reshape(-1, 4)
    return unique, tuple(map(tuple, found.tolist()))
