# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads that Blender draws cut along the other diagonal than the one whose volume is kept.

A quad is drawn as two triangles: cut from its first corner to its third, or, where that would fold it over, from its
second to its fourth. That follows the deformed shape; the triangles whose volume is kept stay those that entered.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.floating[Any]]
Integers = NDArray[np.int32]
Flags = NDArray[np.bool_]

MOST_VERTICES = 2_000_000
"""Of which three indices still make one number of 64 bits."""


def quads_of(corners: Integers, starts: Integers) -> Integers:
    """(Q, 4) vertices of the faces with four corners; ``corners`` in a row, ``starts`` where each face begins."""
    fours = starts[np.diff(starts, append=np.int32(len(corners))) == 4]
    return np.ascontiguousarray(corners[fours[:, None] + np.arange(4, dtype=np.int32)])


def cut_first_to_third(quads: Integers, triangles: Integers) -> Flags:
    """(Q,) whether ``triangles`` (F, 3) cut each quad from its first corner to its third."""
    return np.isin(_keys(quads[:, :3]), _keys(triangles))


def _keys(triangles: Integers) -> NDArray[np.int64]:
    """One number a triangle, whichever corner it begins with."""
    low, middle, high = np.sort(triangles.astype(np.int64), axis=1).T
    return np.asarray((low * MOST_VERTICES + middle) * MOST_VERTICES + high)


def drawn_first_to_third(positions: Positions, quads: Integers) -> Flags:
    """(Q,) how Blender cuts each quad where its corners are at ``positions`` (V, 3): the two triangles on either side
    of that cut must look the same way."""
    first, second, third, fourth = positions[quads].transpose(1, 0, 2)
    diagonal = third - first
    sides = np.einsum("ij,ij->i", np.cross(second - first, diagonal), np.cross(fourth - first, diagonal))
    return np.asarray(sides <= 0.0)


def drawn_volume(positions: Positions, quads: Integers, first_to_third: Flags) -> tuple[int, float]:
    """How many quads are drawn cut otherwise than ``first_to_third`` (Q,) says, and by how much the signed volume that
    is drawn is then larger, in float64."""
    drawn = drawn_first_to_third(positions, quads)
    other = drawn != first_to_third
    first, second, third, fourth = positions.astype(np.float64)[quads[other]].transpose(1, 0, 2)
    apart = np.einsum("ij,ij->i", np.cross(second - first, third - first), fourth - first) / 6.0
    return int(other.sum()), float(np.where(drawn[other], -apart, apart).sum())
