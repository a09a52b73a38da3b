# SPDX-License-Identifier: GPL-3.0-or-later
"""A box of lattice points around vertices."""

import numpy as np
from numpy.typing import NDArray

from .grid import degrees, layers_outside

Array = NDArray[np.float64]

THINNEST = 0.01
"""Least thickness of the box, as a fraction of its largest side: a plane still gets a lattice that can be inverted."""

FLATTEST = 1e-5
"""Thickness below which points count as flat, as a fraction of their largest extent: world coordinates are float32."""

ROUNDING = 4.0 * float(np.finfo(np.float32).eps)
"""Room on each side for the rounding of the lattice's matrix, as a fraction of the largest world coordinate."""


def axes_of(matrix: Array) -> Array:
    """Orthonormal directions (columns) nearest to a transform's axes in order; the world's where it has none."""
    orthogonal, triangular = np.linalg.qr(matrix[:3, :3])
    signs = np.sign(np.diag(triangular))
    if np.any(signs == 0.0):
        return np.eye(3)
    return right_handed(orthogonal * signs)


def right_handed(axes: Array) -> Array:
    """The axes with the last one turned where they are a mirror image, since a lattice's rotation cannot mirror."""
    return axes * (1.0, 1.0, np.sign(np.linalg.det(axes)))


def flat_along(points: Array, axes: Array) -> list[bool]:
    """Of each direction (columns of ``axes``) whether the points (V, 3) have no thickness along it."""
    size = np.ptp(points @ axes, axis=0)
    least = max(FLATTEST * size.max(), 2.0 * ROUNDING * np.abs(points).max())
    return [bool(thickness <= least) for thickness in size]


def box_matrix(points: Array, axes: Array, margin: float, shape: tuple[int, int, int], basis: str) -> Array:
    """4x4 transform of the unit cube about the origin into the box that holds all of ``points`` (V, 3).

    ``axes``: orthonormal columns; ``margin``: fraction of the box's size added on each side. With B-splines the box is
    enlarged by the layers that stand outside their domain, so that the domain holds the points. It is a little wider
    than asked for, since Blender rounds world coordinates to float32, and then the outermost must still be inside.
    Where flat points get one layer, it is as thick as it is long: what bends out of their plane is still inside.
    """
    along = points @ axes
    low, high = along.min(axis=0), along.max(axis=0)
    size = high - low
    largest = size.max() if size.max() > 0.0 else 1.0
    thin = np.array(shape) == 1, flat_along(points, axes)
    size = np.maximum(size, np.where(np.all(thin, axis=0), 1.0, THINNEST) * largest)
    size = size * (1.0 + 2.0 * margin) + 2.0 * ROUNDING * np.abs(points).max()
    if basis == "BSPLINE":
        size = size * [enlargement(count, degree) for count, degree in zip(shape, degrees(shape), strict=True)]
    matrix = np.eye(4)
    matrix[:3, :3] = axes * size
    matrix[:3, 3] = axes @ ((low + high) / 2.0)
    return matrix


def enlargement(points: int, degree: int) -> float:
    """Size of a uniform B-spline's grid over that of its domain."""
    intervals = points - 1
    return 1.0 if intervals == 0 else intervals / (intervals - 2.0 * layers_outside(points, degree))
