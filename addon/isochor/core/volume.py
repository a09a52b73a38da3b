# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh encloses, in float64, and whether that is anything at all."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.floating[Any]]
Triangles = NDArray[np.int32]

SINGLE = float(np.finfo(np.float32).eps)
"""Relative precision of the coordinates that Blender keeps."""


def volume_and_area(positions: Positions, triangles: Triangles) -> tuple[float, float]:
    """Signed volume and area of triangles (F, 3) over positions (V, 3); of an open mesh, the volume of the cone from
    the middle of its vertices."""
    if len(triangles) == 0:
        return 0.0, 0.0
    exact = positions.astype(np.float64)
    a, b, c = (exact - exact.mean(axis=0))[triangles].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    return float(volume), float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def is_flat(positions: Positions, triangles: Triangles) -> bool:
    """Whether the mesh encloses no more than what rounding of its coordinates makes of nothing; the native library
    draws the line in the same place."""
    if len(triangles) == 0:
        return True
    volume, area = volume_and_area(positions, triangles)
    radius = float(np.ptp(positions, axis=0).max()) / 2.0
    return abs(volume) <= 4.0 * SINGLE * area * radius


def enclosed(positions: Positions, triangles: Triangles) -> float:
    """Signed volume that tells one shape of a mesh from another; 0 of a flat one, whose volume is rounding alone."""
    return 0.0 if is_flat(positions, triangles) else volume_and_area(positions, triangles)[0]


def has_changed(before: float, positions: Positions, triangles: Triangles) -> bool:
    """Whether ``enclosed`` is now another than ``before``, by more than 1e-6 of it and by more than moving the whole
    mesh can do, which rounds every coordinate anew."""
    now, area = enclosed(positions, triangles), volume_and_area(positions, triangles)[1]
    rounding = SINGLE * area * float(np.abs(positions).max(initial=0.0))
    return abs(now - before) > max(1e-6 * max(abs(before), abs(now)), rounding)
