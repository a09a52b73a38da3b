# SPDX-License-Identifier: GPL-3.0-or-later
"""Several NURBS surfaces over common points as one welded mesh of fixed rows, so that closed ones enclose a volume.

A seam, or a pole where a whole row of points lies in one place, gives samples that are at the same place for ever: any
deformation moves points at the same place alike. So rows are compared with such points taken for one, and samples of
equal rows become one vertex.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .nurbs import Direction, Rows, surface

Array = NDArray[np.float64]
SAME = 1e-10
"""Difference of two rows' signatures, of numbers of about 1, up to which rows count as equal: float64 rounds less."""


@dataclass(frozen=True)
class Patch:
    """One spline of a surface object: its points from number ``first`` on, u fastest, with ``weights``."""

    first: int
    u: Direction
    v: Direction
    weights: Array = field(repr=False)


@dataclass(frozen=True)
class Shell:
    """Vertices as rows over the points (``offsets``, ``columns``, ``weights``), and ``triangles`` (F, 3) of them."""

    offsets: NDArray[np.int64] = field(repr=False)
    columns: NDArray[np.int64] = field(repr=False)
    weights: Array = field(repr=False)
    triangles: NDArray[np.int32] = field(repr=False)


def shell(patches: Sequence[Patch], points: Array) -> Shell | None:
    """Of points (P, 3) at rest; None where none of the patches is one that Blender draws."""
    drawn = [patch for patch in patches if patch.u.is_valid and patch.v.is_valid]
    if not drawn:
        return None
    found = [(patch, surface(patch.u, patch.v, patch.weights)) for patch in drawn]
    offsets, columns, weights, quads = _joined(found)
    vertex = _welded(offsets, columns, weights, points)
    _, kept = np.unique(vertex, return_index=True)
    lengths = np.diff(offsets)[kept]
    entries = np.concatenate([np.arange(offsets[row], offsets[row + 1]) for row in kept])
    starts = np.concatenate([[0], np.cumsum(lengths)])
    return Shell(starts, columns[entries], weights[entries], _triangles(vertex[quads]))


def _joined(
    found: list[tuple[Patch, Rows]],
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array, NDArray[np.int64]]:
    """All rows and quads one after the other."""
    offsets, columns, weights, quads = [np.zeros(1, np.int64)], [], [], []
    for patch, rows in found:
        quads.append(rows.quads + sum(len(part) for part in offsets) - 1)
        offsets.append(rows.offsets[1:] + offsets[-1][-1])
        columns.append(rows.columns + patch.first)
        weights.append(rows.weights)
    return np.concatenate(offsets), np.concatenate(columns), np.concatenate(weights), np.concatenate(quads)


def _welded(offsets: NDArray[np.int64], columns: NDArray[np.int64], weights: Array, points: Array) -> NDArray[np.int64]:
    """(T,) number of the vertex that each sample becomes."""
    place = np.unique(points, axis=0, return_inverse=True)[1].reshape(-1)
    # Two numbers by chance for each place: rows that differ hardly ever agree in both sums.
    chance = np.random.default_rng(1).standard_normal((int(place.max()) + 1, 2))
    sums = np.add.reduceat(weights[:, None] * chance[place[columns]], offsets[:-1], axis=0)
    groups = np.stack([_runs(column) for column in sums.T], axis=1)
    return np.asarray(np.unique(groups, axis=0, return_inverse=True)[1].reshape(-1), np.int64)


def _runs(values: Array) -> NDArray[np.int64]:
    """(T,) number of the run of hardly differing values that each value is in."""
    order = np.argsort(values)
    runs = np.empty(len(values), np.int64)
    runs[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > SAME)])
    return runs


def _triangles(quads: NDArray[np.int64]) -> NDArray[np.int32]:
    """(F, 3) two of each quad, cut from its first to its third corner, without those that a pole has made lines."""
    both = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    a, b, c = both.T
    return np.ascontiguousarray(both[(a != b) & (b != c) & (c != a)], np.int32)
