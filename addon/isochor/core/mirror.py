# SPDX-License-Identifier: GPL-3.0-or-later
"""One side of a lattice's points onto the other, mirrored in the middle of the undeformed grid.

That middle is the origin of the lattice's own space, about which Blender lays every grid.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.floating[Any]]
Shape = tuple[int, int, int]


def mirrored(points: Points, shape: Shape, axis: int, to_positive: bool, chosen: NDArray[np.bool_] | None) -> Points:
    """Points (N, 3) in lattice space, u fastest, with one side along ``axis`` made the mirror image of the other.

    Which side a point is on is its place in the grid of ``shape`` (u, v, w), wherever it was moved to. A middle layer
    is put onto the plane. ``chosen`` (N,): only pairs of which a point is chosen change; None is all.
    """
    grid = points.reshape(*shape[::-1], 3)
    along = 2 - axis
    image = np.flip(grid, along).copy()
    image[..., axis] *= -1.0
    middle = grid.copy()
    middle[..., axis] = 0.0
    side = 2 * np.arange(shape[axis]) - (shape[axis] - 1)
    side = side.reshape([-1 if dimension == along else 1 for dimension in range(3)])
    is_target = side > 0 if to_positive else side < 0
    changes = np.ones(grid.shape[:3], bool)
    if chosen is not None:
        picked = chosen.reshape(grid.shape[:3])
        changes = picked | np.flip(picked, along)
    result = np.where((changes & is_target)[..., None], image, grid)
    result = np.where((changes & (side == 0))[..., None], middle, result)
    return result.reshape(points.shape)
