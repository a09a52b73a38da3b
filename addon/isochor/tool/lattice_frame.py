# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the lattice of a modifier stands in the world, and the mesh in it, now."""

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import grid
from . import evaluated, own_points, sockets
from .entered import Entered

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatticeFrame:
    """``matrix`` (4, 4) lattice to world; ``low``, ``high`` corners of the basis's domain in lattice space."""

    matrix: Array
    low: Array
    high: Array

    @property
    def lengths(self) -> Array:
        """World length of one unit of lattice space on each axis."""
        return np.asarray(np.linalg.norm(self.matrix[:3, :3], axis=0))

    def direction(self, axis: int) -> Array:
        """Unit vector in the world, from bottom to top."""
        return np.asarray(grid.unit_columns(self.matrix)[:, axis])

    def end(self, axis: int, place: float) -> Array:
        """World point on the line through the middle along the axis, 0 at the domain's bottom and 1 at its top."""
        point = (self.low + self.high) / 2.0
        point[axis] = self.low[axis] + place * (self.high[axis] - self.low[axis])
        return np.asarray(self.matrix[:3, :3] @ point + self.matrix[:3, 3])


def of(modifier: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> LatticeFrame | None:
    """Of the lattice that the modifier names, as evaluated; None where it names none, or one without a size."""
    lattice = sockets.read(modifier, sockets.LATTICE)
    if lattice is None or lattice.type != "LATTICE":
        return None
    held = lattice.evaluated_get(depsgraph)
    matrix = evaluated.matrix(held)
    if abs(np.linalg.det(grid.unit_columns(matrix))) < 1e-12:
        return None
    points = evaluated.lattice_points(held)
    basis = sockets.read(modifier, "Basis")
    low, high = grid.domain_box(grid.Grid(points.shape, points.low, points.high, basis, np.eye(4)))
    return LatticeFrame(matrix, low, high)


def goes_along(lattice: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether the lattice moves with the object: as its child, as a child of the same parent, or by a constraint."""
    return bool(lattice.constraints) or not _line(lattice).isdisjoint(_line(obj))


def _line(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """The object and its parents, all the way up."""
    found = set()
    while obj is not None:
        found.add(obj)
        obj = obj.parent
    return found


def entering(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph
) -> NDArray[np.float64]:
    """(V, 3) world positions of the points that enter the modifier; of those shown where that is not known."""
    held = obj.evaluated_get(depsgraph)
    found = Entered(held, str(modifier.persistent_uid), followed=False).positions
    own = own_points.shown(held) if found is None else found
    matrix = evaluated.matrix(held)
    return np.asarray(own.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
