# SPDX-License-Identifier: GPL-3.0-or-later
"""Adjacent lattices held together: where faces of two blocks meet, one's control points follow from the other's so that
the two deformations join without a gap (C0) or a crease (C1).

Points are given as displacements from the undeformed grids, in the space of both grids: where nothing is displaced,
nothing follows. Faces are named as in ``isochor.Lattice.frozen``: s0 and s1 are first and last along the first axis.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from . import problem
from .grid import Grid, degrees, domain_box

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Share = tuple[float, ...]

FACES = ("s0", "s1", "t0", "t1", "u0", "u1")
NEAR = 1e-3
"""How far apart faces may be, as a fraction of their size: more than matrices are rounded, less than one can see."""
PARALLEL = 1e-3
"""Largest angle, in radians, between the ways in which two blocks with a C1 joint lead away from it."""


def place(face: str) -> tuple[int, int]:
    """Axis of a face and which end of it, 0 or 1."""
    return "stu".index(face[0]), int(face[1])


@dataclass(frozen=True)
class Face:
    """One side of a block: ``corners`` (2, 2, 3) of what the basis reaches, along the two other axes in order, and
    ``outward``, the edge of the block that leads to it."""

    grid: Grid
    name: str

    @cached_property
    def corners(self) -> Array:
        low, high = domain_box(self.grid)
        axis, end = place(self.name)
        found = np.empty((2, 2, 3))
        for i, j in product((0, 1), repeat=2):
            ends = [i, j]
            ends.insert(axis, end)
            found[i, j] = np.where(np.array(ends) == 1, high, low)
        return found @ self.grid.to_object[:3, :3].T + self.grid.to_object[:3, 3]

    @cached_property
    def outward(self) -> Array:
        axis, end = place(self.name)
        low, high = domain_box(self.grid)
        edge = self.grid.to_object[:3, axis] * (high[axis] - low[axis])
        return np.asarray(edge if end else -edge)

    @property
    def size(self) -> float:
        """Longest edge of the face."""
        found = self.corners
        return float(max(np.linalg.norm(found[1] - found[0], axis=-1).max(), np.linalg.norm(np.diff(found, axis=1))))

    @property
    def counts(self) -> tuple[int, int]:
        """Points along the two axes of the face."""
        u, v = (count for axis, count in enumerate(self.grid.shape) if axis != place(self.name)[0])
        return u, v

    def rows(self, continuity: int) -> Array:
        """(continuity + 1, n) what of n layers, first to last, makes the value at the face, and its derivative along
        ``outward`` by length."""
        axis, end = place(self.name)
        count = self.grid.shape[axis]
        value, slope, cells = self._start(axis, count)
        found = np.zeros((2, count))
        found[0, : len(value)] = value
        found[1, : len(slope)] = np.multiply(slope, -cells / np.linalg.norm(self.outward))
        return found[: continuity + 1, :: -1 if end else 1]

    def _start(self, axis: int, count: int) -> tuple[Share, Share, int]:
        """Value and derivative by cells at the start of an axis, in its first layers, and how many cells it has."""
        if self.grid.basis == "B-Spline":
            degree = degrees(self.grid.shape)[axis]
            return *UNIFORM[degree], count - degree
        if self.grid.basis == "Blender" and self.grid.interpolation is not None:
            return *NATIVE[self.grid.interpolation[axis]], count - 1
        return (1.0,), (1.0 - count, count - 1.0), 1

    @property
    def types(self) -> tuple[str, ...]:
        """How points blend along the two axes of the face, where that is Blender's own business."""
        kinds = self.grid.interpolation or ()
        return tuple(kind for axis, kind in enumerate(kinds) if axis != place(self.name)[0])

    def held(self, continuity: int) -> Mask:
        """(nu, nv, nw) the points that shape the joint."""
        layers = np.any(self.rows(continuity) != 0.0, axis=0)
        shape = [1, 1, 1]
        shape[place(self.name)[0]] = -1
        return np.broadcast_to(layers.reshape(shape), self.grid.shape)


UNIFORM: dict[int, tuple[Share, Share]] = {
    0: ((1.0,), (0.0,)),
    1: ((1.0, 0.0), (-1.0, 1.0)),
    2: ((1 / 2, 1 / 2), (-1.0, 1.0)),
    3: ((1 / 6, 4 / 6, 1 / 6), (-1 / 2, 0.0, 1 / 2)),
}
"""Of uniform B-splines by degree: value and derivative by cells at the start of the domain, in the first layers."""

NATIVE: dict[str, tuple[Share, Share]] = {
    "KEY_LINEAR": ((1.0,), (-1.0, 1.0)),
    "KEY_CARDINAL": ((1.0,), (-0.71, 0.71)),
    "KEY_CATMULL_ROM": ((1.0,), (-0.5, 0.5)),
    "KEY_BSPLINE": ((5 / 6, 1 / 6), (-1 / 2, 1 / 2)),
}
"""The same at the first point of Blender's own lattice, beyond which the first layer counts once more."""

Turn = tuple[bool, bool, bool]
"""Whether to swap the two axes of a face, then to reverse the first, then the second."""


def turned(values: Array, turn: Turn) -> Array:
    """(n, m, …) values over a face, seen from the other block."""
    swap, first, second = turn
    found = values.swapaxes(0, 1) if swap else values
    return found[:: -1 if first else 1, :: -1 if second else 1]


def meeting(one: Face, other: Face) -> tuple[float, Turn]:
    """How far the corners of the other face are at most from those of the one, and the turn that brings the other's
    order into that of the one so that they are nearest."""
    turns: list[Turn] = [(swap, first, second) for swap, first, second in product((False, True), repeat=3)]
    gaps = [float(np.linalg.norm(turned(other.corners, turn) - one.corners, axis=-1).max()) for turn in turns]
    nearest = int(np.argmin(gaps))
    return gaps[nearest], turns[nearest]


def nearest_faces(one: Grid, other: Grid) -> tuple[float, str, str]:
    """The two faces of two blocks, each on the other side of the joint, that are nearest to meeting: how far they are
    apart, and their names."""
    best = (np.inf, "", "")
    for face, opposite in product(faces(one), faces(other)):
        if np.dot(face.outward, opposite.outward) < 0.0:
            gap, _turn = meeting(face, opposite)
            best = min(best, (gap, face.name, opposite.name))
    return best


def faces(grid: Grid) -> list[Face]:
    """Those that another block can be tied to: with one layer of points along an axis there are none across it."""
    return [Face(grid, name) for name in FACES if grid.shape[place(name)[0]] > 1]


def meets(gap: float, one: Grid, face: str) -> bool:
    """Whether faces so far apart coincide."""
    return gap <= NEAR * Face(one, face).size


class Tie:
    """The joint of a face of block "a" with a face of block "b", C0 or C1. ``names`` are those of the two blocks.

    Raises ``Problem`` where the faces do not coincide, have other numbers of points, or lead away from the joint in
    different directions.
    """

    def __init__(self, a: Face, b: Face, continuity: int, names: tuple[str, str]) -> None:
        gap, self._turn = meeting(a, b)
        if not meets(gap, a.grid, a.name):
            raise problem.Problem(problem.apart(*names, gap))
        swapped = self._turn[0]
        if a.grid.basis != b.grid.basis or a.types != (b.types[::-1] if swapped else b.types):
            raise problem.Problem(problem.tied_bases(*names))
        if a.counts != (b.counts[::-1] if swapped else b.counts):
            raise problem.Problem(problem.tied_counts(*names, a.counts, b.counts))
        if continuity > 0 and np.linalg.norm(unit(a.outward) + unit(b.outward)) > PARALLEL:
            raise problem.Problem(problem.tied_askew(*names))
        self.a, self.b, self._continuity = a, b, continuity

    def follow(self, leader: Array, follower: Array, leads: str) -> Array:
        """The follower's displacements (nu, nv, nw, 3), with the least change that continues the leader's; ``leads``
        is "a" or "b"."""
        first, second = (self.a, self.b) if leads == "a" else (self.b, self.a)
        axis, other = place(first.name)[0], place(second.name)[0]
        wanted = np.einsum("rk,k...->r...", first.rows(self._continuity), np.moveaxis(leader, axis, 0))
        wanted[1:] *= -1.0
        wanted = np.stack([self._seen(layer, leads) for layer in wanted])
        rows, layers = second.rows(self._continuity), np.moveaxis(follower, other, 0)
        missing = wanted - np.einsum("rk,k...->r...", rows, layers)
        change = np.einsum("kr,r...->k...", np.linalg.pinv(rows), missing)
        change[~np.any(rows != 0.0, axis=0)] = 0.0
        return np.asarray(follower + np.moveaxis(change, 0, other))

    def _seen(self, layer: Array, leads: str) -> Array:
        """A layer of the leader in the follower's order."""
        if leads == "b":
            return turned(layer, self._turn)
        swap, first, second = self._turn
        flipped = layer[:: -1 if first else 1, :: -1 if second else 1]
        return flipped.swapaxes(0, 1) if swap else flipped


def unit(vector: Array) -> Array:
    """The same direction, of length one."""
    return np.asarray(vector / np.linalg.norm(vector))
