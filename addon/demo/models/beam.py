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
