# SPDX-License-Identifier: GPL-3.0-or-later
"""What the file keeps of a lattice whose rest was set: a custom property of the modifier's result objects."""

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.blending import Blending
from ..core.bound import BoundShape, Embedding

BOUND = "isochor_bound"
"""Custom property of a result object: the lattice as it stood when the rest was set."""
COUNT = "vertices"
"""In it: number of vertices of the object's own mesh at that time."""


@dataclass
class BoundCache:
    """What a result object holds, read again only where it has changed."""

    stamp: str = ""
    shape: BoundShape | None = None
    embedded: Embedding | None = None

    def look_at(self, result: bpy.types.Object | None) -> None:
        """Reads what the modifier with this result object is bound with."""
        kept = None if result is None else result.get(BOUND)
        stamp = "" if kept is None else kept["stamp"]
        if stamp != self.stamp:
            self.stamp, self.embedded = stamp, None
            self.shape = None if kept is None else _read(kept)

    def refuse_other(self, lattice: str, shape: tuple[int, int, int]) -> None:
        """Raises a Problem where the lattice, by its present name, has another resolution than when it was bound."""
        if self.shape is not None:
            self.shape.refuse_other(lattice, shape)

    def embedding(self, blending: Blending) -> Embedding | None:
        """Of what was read last, where points blend so; the very same object as before where nothing has changed."""
        if self.shape is None:
            return None
        if self.embedded is None or not self.embedded.grid.blends_as(blending):
            self.embedded = self.shape.embedding(blending)
        return self.embedded


def keep(result: bpy.types.Object, shape: BoundShape, vertices: int) -> None:
    """Has a modifier's result object hold what it is bound with, and how many vertices the object's mesh has."""
    result[BOUND] = _written(shape, vertices)


def forget(result: bpy.types.Object) -> None:
    """The modifier is no longer bound."""
    if BOUND in result:
        del result[BOUND]


def forget_of_other(result: bpy.types.Object, vertices: int) -> None:
    """The same where the mesh has another number of vertices, as after copying the modifier to another object."""
    if BOUND in result and result[BOUND][COUNT] != vertices:
        forget(result)


def bound_with(result: bpy.types.Object | None) -> tuple[str, tuple[int, int, int]] | None:
    """Name and resolution of the lattice that the modifier with this result object is bound with, or None."""
    kept = None if result is None else result.get(BOUND)
    return None if kept is None else (kept["lattice"], tuple(kept["shape"]))


def _written(shape: BoundShape, vertices: int) -> dict[str, object]:
    return {
        "stamp": shape.stamp,
        COUNT: vertices,
        "lattice": shape.lattice,
        "shape": list(shape.shape),
        "low": [float(number) for number in shape.low],
        "high": [float(number) for number in shape.high],
        "to_object": shape.to_object.ravel().tolist(),
        "points": shape.points.astype(np.float64).tolist(),
    }


def _read(kept: bpy.types.PropertyGroup) -> BoundShape:
    u, v, w = kept["shape"]
    (x, y, z), (p, q, r) = kept["low"], kept["high"]
    to_object = np.array(kept["to_object"], np.float64).reshape(4, 4)
    points = np.array(kept["points"], np.float64).astype(np.float32)
    return BoundShape(kept["lattice"], (u, v, w), (x, y, z), (p, q, r), to_object, points)
