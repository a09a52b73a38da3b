# SPDX-License-Identifier: GPL-3.0-or-later
"""Tied blocks on one mesh: each vertex belongs to one of them, by where it stands before the first of them."""

from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.blending import Blending
from ..core.grid import Grid, relative_transform
from ..core.request import Vertices
from ..core.sharing import Share, Shares
from . import evaluated, results
from .bound import BoundCache
from .chain import Chain


@dataclass
class Neighbours:
    """What one modifier remembers of those beside it."""

    shares: Shares = field(default_factory=Shares)
    bound: dict[int, BoundCache] = field(default_factory=dict)

    def share(
        self,
        blocks: list[tuple[bpy.types.NodesModifier, bpy.types.Object]],
        modifier: bpy.types.NodesModifier,
        before: Chain | None,
        entered: Vertices,
        grids: tuple[Grid, ...],
        keep: bool,
    ) -> Share:
        """What the modifier holds of the mesh of which ``entered`` enters it; ``keep``: it leaves vertices alone that
        are outside of all blocks."""
        first = blocks[0][0].persistent_uid
        start = entered if before is None else before.entries.get(first, entered)
        place = next(number for number, (other, _lattice) in enumerate(blocks) if other == modifier)
        return self.shares.of(start, grids, place, keep)

    def grid(
        self,
        modifier: bpy.types.NodesModifier,
        lattice: bpy.types.Object,
        basis: str,
        object_matrix: NDArray[np.float64],
        depsgraph: bpy.types.Depsgraph,
    ) -> Grid:
        """The undeformed lattice of a modifier beside this one, or as it stood when its rest was set, in the space of
        the object that both deform."""
        cache = self.bound.setdefault(modifier.persistent_uid, BoundCache())
        cache.look_at(results.of(modifier, depsgraph.mode))
        bound = cache.embedding(Blending(basis))
        if bound is not None:
            return bound.grid
        shown = lattice.evaluated_get(depsgraph)
        points = evaluated.lattice_points(shown)
        names = (modifier.id_data.name, lattice.name)
        transform = relative_transform(object_matrix, evaluated.matrix(shown), names)
        return Grid(points.shape, points.low, points.high, basis, transform)
