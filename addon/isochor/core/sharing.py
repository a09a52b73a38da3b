# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks side by side: each vertex belongs to one of them, by where it stands before any of them moves it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import same_array
from .grid import Grid, domain_box
from .volume import SINGLE

Positions = NDArray[np.floating[Any]]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass
class Shares:
    """Whose the vertices are, found anew only where the mesh or a block is another."""

    positions: Positions | None = field(default=None, repr=False)
    grids: tuple[Grid, ...] = ()
    owners: NDArray[np.int32] | None = field(default=None, repr=False)
    weights: dict[int, NDArray[np.float32]] = field(default_factory=dict, repr=False)

    def influence(self, positions: Positions, grids: tuple[Grid, ...], block: int) -> NDArray[np.float32]:
        """(V,) 1 for the vertices of one block and 0 for all others, of positions (V, 3) in the space of the grids;
        the very same array as long as nothing changes."""
        if self.owners is None or not alike(grids, self.grids) or not same_array(positions, self.positions):
            self.positions, self.grids, self.weights = positions, grids, {}
            self.owners = nearest(positions, grids)
        if block not in self.weights:
            self.weights[block] = (self.owners == block).astype(np.float32)
        return self.weights[block]


def nearest(positions: Positions, grids: tuple[Grid, ...]) -> NDArray[np.int32]:
    """(V,) index of the block that each vertex is in, or nearest to; of several the first."""
    best = np.full(len(positions), np.inf)
    found = np.zeros(len(positions), np.int32)
    for number, grid in enumerate(grids):
        low, high = domain_box(grid)
        inside = (positions - grid.to_object[:3, 3]) @ np.linalg.inv(grid.to_object[:3, :3]).T
        beyond = np.maximum(low - inside, 0.0) + np.maximum(inside - high, 0.0)
        distance = np.einsum("vi,vi->v", *(2 * [beyond @ grid.to_object[:3, :3].T]))
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
