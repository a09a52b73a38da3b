# SPDX-License-Identifier: GPL-3.0-or-later
"""A Bernstein lattice with more points and the very same deformation: degree elevation."""

from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

Shape = tuple[int, int, int]


def elevated(points: NDArray[np.floating[Any]], before: Shape, after: Shape) -> NDArray[np.float64]:
    """Points (N, 3), u fastest, of the lattice with ``after`` points a side (none fewer than ``before``) that maps
    everything to where the lattice of these points maps it. Where a side had one point, the new layers are moved as
    that was, from where they lie evenly in the unit cube about the middle."""
    grid = points.reshape(*before[::-1], 3).astype(np.float64)
    for axis in range(3):
        grid = np.moveaxis(np.tensordot(matrix(before[axis], after[axis]), grid, (1, 2 - axis)), 0, 2 - axis)
        if before[axis] == 1:
            layers = np.linspace(-0.5, 0.5, after[axis]) if after[axis] > 1 else np.zeros(1)
            grid[..., axis] += layers.reshape([-1 if dimension == 2 - axis else 1 for dimension in range(3)])
    return grid.reshape(-1, 3)


def matrix(before: int, after: int) -> NDArray[np.float64]:
    """(after, before) weights of the old points in each new one."""
    added = after - before
    rows = [
        [comb(before - 1, old) * comb(added, new - old) if 0 <= new - old <= added else 0 for old in range(before)]
        for new in range(after)
    ]
    return np.array(rows, np.float64) / np.array([[comb(after - 1, new)] for new in range(after)], np.float64)
