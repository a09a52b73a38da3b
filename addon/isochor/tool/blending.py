# SPDX-License-Identifier: GPL-3.0-or-later
"""How the control points of a modifier's lattice blend in one frame: what its inputs and the lattice object say."""

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import lattice_group, problem
from ..core.arrays import same_array
from ..core.blending import OVERSHOOTING, Blending, pulls
from ..core.bound import Embedding
from ..core.grid import Grid
from ..core.settings import Settings
from . import evaluated, sockets
from .lattice_weights import GroupCache, Weights

Influence = NDArray[np.float32]


@dataclass
class BlendingCache:
    """What one modifier keeps of its lattice's groups between frames."""

    weights: GroupCache = field(default_factory=lambda: GroupCache(sockets.WEIGHTS))
    own: GroupCache = field(default_factory=lambda: GroupCache("Vertex Group"))
    _shares: NDArray[np.float64] | None = field(default=None, repr=False)
    _of: "tuple[Grid, Embedding | None, NDArray[Any], Weights] | None" = field(default=None, repr=False)

    def shares(self, grid: Grid, bound: Embedding | None, positions: NDArray[Any], group: Weights) -> Any:
        """``lattice_group.shares``, worked out anew only where something has changed."""
        before = self._of
        known = (
            before is not None
            and before[1] is bound
            and before[0].same_as(grid)
            and same_array(before[2], positions)
            and same_array(before[3], group)
        )
        if not known or self._shares is None:
            self._shares = lattice_group.shares(grid, bound, positions, group)
            self._of = grid, bound, positions, group
        return self._shares


def read(cache: BlendingCache, settings: Settings, lattice: bpy.types.Object, edits: int) -> tuple[Blending, list[str]]:
    """Of an evaluated lattice, whose data was edited so many times; and what is wrong."""
    problems: list[str] = []
    if settings.joint != "Free" and settings.outside != "Keep":
        problems.append(problem.JOINT_EXTENDS)
    interpolation = evaluated.interpolation(lattice) if settings.basis == "Blender" else None
    weights = None
    if settings.weights:
        try:
            weights = pulls(cache.weights.of(lattice, settings.weights, edits), settings.heaviest)
        except problem.Problem as trouble:
            problems.append(trouble.sentence)
    if weights is not None and set(interpolation or ()) & set(OVERSHOOTING):
        problems.append(problem.WEIGHTS_OVERSHOOT)
        weights = None
    return Blending(settings.basis, interpolation, weights), problems


def weakened(
    cache: BlendingCache,
    lattice: bpy.types.Object,
    edits: int,
    placed: tuple[Grid, Embedding | None, NDArray[Any]],
    influence: Influence | None,
) -> tuple[Influence | None, list[str]]:
    """How much of the deformation each vertex takes where the lattice names a vertex group of its own, which counts
    with Blender's basis alone; and what is wrong. ``placed``: the lattice, as it is bound, and the vertices."""
    grid, bound, positions = placed
    name = lattice.data.vertex_group if grid.basis == "Blender" else ""
    if not name or name not in lattice.vertex_groups:
        return influence, []
    try:
        group = cache.own.of(lattice, name, edits)
    except problem.Problem as trouble:
        return influence, [trouble.sentence]
    return lattice_group.weakened(influence, cache.shares(grid, bound, positions, group)), []
