# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks side by side: each vertex belongs to one of them, by where it stands before any of them moves it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import same_array
from .grid import Grid, domain_box
from .tie import FACES
from .volume import SINGLE

Positions = NDArray[np.floating[Any]]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class Share:
    """What one of the blocks holds: ``weights`` (V,) 1 for its vertices and 0 for others; ``beyond``: its faces beyond
    which vertices lie that no block holds."""

    weights: NDArray[np.float32] = field(repr=False)
    beyond: tuple[str, ...] = ()


@dataclass
class Shares:
    """Whose the vertices are, found anew only where the mesh or a block is another."""

    positions: Positions | None = field(default=None, repr=False)
    grids: tuple[Grid, ...] = ()
    keep: bool = True
    owners: NDArray[np.int32] | None = field(default=None, repr=False)
    found: dict[int, Share] = field(default_factory=dict, repr=False)

    def of(self, positions: Positions, grids: tuple[Grid, ...], block: int, keep: bool) -> Share:
        """The share of one block, of positions (V, 3) in the space of the grids. Of vertices outside of all blocks it
        has those that it is nearest to, or none where ``keep``. The very same object as long as nothing changes."""
        same = self.keep == keep and alike(grids, self.grids) and same_array(positions, self.positions)
        if self.owners is None or not same:
            self.positions, self.grids, self.keep, self.found = positions, grids, keep, {}
            self.owners = nearest(positions, grids)
        if block not in self.found:
            own = self.owners == block
            outside = _beyond(positions[own], grids[block]) if keep else np.zeros((int(own.sum()), 3))
            weights = own.astype(np.float32)
            weights[own] = ~np.any(outside != 0.0, axis=1)
            self.found[block] = Share(weights, _faces(outside))
        return self.found[block]


def nearest(positions: Positions, grids: tuple[Grid, ...]) -> NDArray[np.int32]:
    """(V,) index of the block that each vertex is in, or nearest to; of several the first."""
    best = np.full(len(positions), np.inf)
    found = np.zeros(len(positions), np.int32)
    for number, grid in enumerate(grids):
        beyond = _beyond(positions, grid) @ grid.to_object[:3, :3].T
        distance = np.einsum("vi,vi->v", beyond, beyond)
        nearer = distance < best
        best[nearer], found[nearer] = distance[nearer], number
    return found


def alike(grids: tuple[Grid, ...], others: tuple[Grid, ...]) -> bool:
    """Whether the two are the same blocks, in places that differ by no more than ``widened`` makes up for."""
    return len(grids) == len(others) and all(
        (one.shape, one.low, one.high, one.basis) == (other.shape, other.low, other.high, other.basis)
        and np.abs(one.to_object - other.to_object).max() <= rounding(other.to_object)
        for one, other in zip(grids, others, strict=True)
    )


def rounding(matrix: NDArray[np.float64]) -> float:
    """By how much Blender's matrices of a block that stands so may be off."""
    return 4.0 * SINGLE * float(np.abs(matrix[:3, :3]).sum(axis=1).max() + np.abs(matrix[:3, 3]).max())


def widened(matrix: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    """The transform of a block whose undeformed points fill ``box``, made larger about its middle by what coordinates
    are rounded, so that no vertex falls between blocks that meet."""
    size, middle = np.subtract(*box[::-1]), np.add(*box) / 2.0
    lengths = np.linalg.norm(matrix[:3, :3], axis=0) * np.where(size > 0.0, size, 1.0)
    factors = 1.0 + 4.0 * rounding(matrix) / np.where(lengths > 0.0, lengths, np.inf)
    found = matrix.copy()
    found[:3, :3] *= factors
    found[:3, 3] += (matrix[:3, :3] - found[:3, :3]) @ middle
    return found


def _beyond(positions: Positions, grid: Grid) -> NDArray[np.float64]:
    """(V, 3) by how much of lattice space each vertex is outside of what a block reaches, signed; 0 where that is
    rounding."""
    low, high = domain_box(grid)
    inside = (positions - grid.to_object[:3, 3]) @ np.linalg.inv(grid.to_object[:3, :3]).T
    found = np.minimum(inside - low, 0.0) + np.maximum(inside - high, 0.0)
    lengths = np.linalg.norm(grid.to_object[:3, :3], axis=0)
    return np.asarray(np.where(np.abs(found) * lengths <= rounding(grid.to_object), 0.0, found))


def _faces(beyond: NDArray[np.float64]) -> tuple[str, ...]:
    sides = [side for axis in beyond.T for side in (np.any(axis < 0.0), np.any(axis > 0.0))]
    return tuple(face for face, side in zip(FACES, sides, strict=True) if side)
