# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces as Blender stores them (corners in a row, and where each face starts) into triangles."""

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int32]


def split_small_faces(corners: Integers, starts: Integers) -> Integers | None:
    """(F, 3) triangles of faces with three or four corners, or None where one has more.

    A quad is cut from its first corner to its third, as Blender does where it is convex. The cut does not depend on
    positions, so every frame has the same triangles.
    """
    sizes = np.diff(starts, append=np.int32(len(corners)))
    if len(sizes) == 0 or sizes.min() < 3 or sizes.max() > 4:
        return None
    if sizes.max() == 3:
        return np.ascontiguousarray(corners.reshape(-1, 3))
    threes, fours = starts[sizes == 3], starts[sizes == 4]
    offsets = np.concatenate([threes[:, None] + (0, 1, 2), fours[:, None] + (0, 1, 2), fours[:, None] + (0, 2, 3)])
    return np.ascontiguousarray(corners[offsets], dtype=np.int32)
