# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles of a closed surface made of rings, one above the other (numpy only)."""

import numpy as np
from numpy.typing import NDArray


def ring_triangles(count: int, sides: int) -> NDArray[np.int32]:
    """(F, 3) vertex indices, wound outwards, of ``count`` points: rings of ``sides`` points from the bottom up, then
    the bottom's and the top's middle."""
    rings = (count - 2) // sides
    here = np.arange(rings * sides, dtype=np.int32).reshape(rings, sides)
    beside = np.roll(here, -1, axis=1)
    bottom, top = np.full(sides, count - 2), np.full(sides, count - 1)
    parts = [
        np.stack([here[:-1], beside[:-1], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([here[:-1], beside[1:], here[1:]], axis=-1).reshape(-1, 3),
        np.stack([bottom, beside[0], here[0]], axis=-1),
        np.stack([top, here[-1], beside[-1]], axis=-1),
    ]
    return np.ascontiguousarray(np.concatenate(parts), dtype=np.int32)
