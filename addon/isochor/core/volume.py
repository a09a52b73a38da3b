# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh encloses, in float64, and whether that is anything at all."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.floating[Any]]
Triangles = NDArray[np.int32]

SINGLE = float(np.finfo(np.float32).eps)
"""Relative precision of the coordinates that Blender keeps."""


class Measures(NamedTuple):
    """Signed volume, area and half the largest extent of a mesh; of an open one, the volume of the cone from the
    middle of its vertices."""

    volume: float
    area: float
    radius: float

    @property
    def is_flat(self) -> bool:
        """Whether the volume is no more than what rounding of the coordinates makes of nothing; the native library
        draws the line in the same place."""
        return abs(self.volume) <= 4.0 * SINGLE * self.area * self.radius


def measures(positions: Positions, triangles: Triangles) -> Measures:
    """Of triangles (F, 3) over positions (V, 3)."""
    if len(triangles) == 0:
        return Measures(0.0, 0.0, 0.0)
    exact = positions.astype(np.float64)
    a, b, c = (exact - exact.mean(axis=0))[triangles].transpose(1, 0, 2)
    doubled = np.cross(b - a, c - a)
    volume = float(np.einsum("ij,ij->", a, doubled)) / 6.0
    area = float(np.sqrt(np.einsum("ij,ij->i", doubled, doubled)).sum()) / 2.0
    return Measures(volume, area, float(np.ptp(exact, axis=0).max()) / 2.0)


def is_flat(positions: Positions, triangles: Triangles) -> bool:
    """Whether the mesh encloses no more than what rounding of its coordinates makes of nothing."""
    return measures(positions, triangles).is_flat


def enclosed(positions: Positions, triangles: Triangles) -> float:
    """Signed volume that tells one shape of a mesh from another; 0 of a flat one, whose volume is rounding alone."""
    found = measures(positions, triangles)
    return 0.0 if found.is_flat else found.volume


def has_changed(before: float, positions: Positions, triangles: Triangles) -> bool:
    """Whether ``enclosed`` is now another than ``before``, by more than 1e-6 of it and by more than moving the whole
    mesh can do, which rounds every coordinate anew."""
    found = measures(positions, triangles)
    now = 0.0 if found.is_flat else found.volume
    rounding = SINGLE * found.area * float(np.abs(positions).max(initial=0.0))
    return abs(now - before) > max(1e-6 * max(abs(before), abs(now)), rounding)
