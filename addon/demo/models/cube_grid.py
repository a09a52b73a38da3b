# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a cube as an even grid without seams (numpy only)."""

import numpy as np
from numpy.typing import NDArray


def cube_grid(cells: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """(6 cells² + 2, 3) points on the surface of the cube from -1 to 1, and (12 cells², 3) triangles wound outwards."""
    steps = np.arange(cells + 1)
    first, second = (place.ravel() for place in np.meshgrid(steps, steps, indexing="ij"))
    corners, faces = [], []
    for axis in range(3):
        for far in (0, cells):
            corner = np.empty((len(first), 3), dtype=np.int64)
            corner[:, axis], corner[:, (axis + 1) % 3], corner[:, (axis + 2) % 3] = far, first, second
            faces.append(_face_triangles(cells, outwards=far > 0) + len(first) * len(corners))
            corners.append(corner)
    points, place = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    triangles = place.reshape(-1)[np.concatenate(faces)]
    return 2.0 * points / cells - 1.0, np.ascontiguousarray(triangles, dtype=np.int32)


def _face_triangles(cells: int, outwards: bool) -> NDArray[np.int64]:
    here = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = here[:-1, :-1], here[1:, :-1], here[1:, 1:], here[:-1, 1:]
    triangles = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    return triangles if outwards else triangles[:, ::-1]
