# SPDX-License-Identifier: GPL-3.0-or-later
"""Adjacent lattices held together: where faces of two blocks meet, one's control points follow from the other's so that
the two deformations join without a gap (C0) or a crease (C1).

Points are given as displacements from the undeformed grids, in the space of both grids: where nothing is displaced,
nothing follows. Faces are named as in ``isochor.Lattice.frozen``: s0 and s1 are first and last along the first axis.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import isochor

from . import problem
from .grid import Grid, build_lattice, domain_box

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Side = Literal["a", "b"]

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

    @property
    def types(self) -> tuple[str, ...]:
        """How points blend along the two axes of the face, where that is Blender's own business."""
        kinds = self.grid.interpolation or ()
        return tuple(kind for axis, kind in enumerate(kinds) if axis != place(self.name)[0])

    def held(self, continuity: int) -> Mask:
        """(nu, nv, nw) the points that shape the joint."""
        return build_lattice(replace(self.grid, to_object=np.eye(4))).frozen(continuity, (self.name,))

    def layers(self, continuity: int) -> int:
        """How many layers those are."""
        return int(np.moveaxis(self.held(continuity), place(self.name)[0], 0).any(axis=(1, 2)).sum())


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
        one = _built(a.grid, _moved(a.grid, -a.corners[0, 0]), names[0])
        other = _built(b.grid, self._put_onto(a, b), names[1])
        self._rest = {"a": one.rest, "b": other.rest}
        self._native = isochor.Tie(one, a.name, other, b.name, continuity)

    def follow(self, leader: Array, follower: Array, leads: Side) -> Array:
        """The follower's displacements (nu, nv, nw, 3), with the least change that continues the leader's; ``leads``
        is "a" or "b"."""
        rest = self._rest["b" if leads == "a" else "a"]
        return self._native.apply(self._rest[leads] + leader, rest + follower, leads) - rest

    def _put_onto(self, a: Face, b: Face) -> Array:
        """4x4: the space of block b into one in which its face is that of block a, whose first corner is the origin.
        Only lengths and the order of points matter to a joint: what the faces miss each other by is left out."""
        swap, first, second = self._turn
        flipped = (a.corners - a.corners[0, 0])[:: -1 if first else 1, :: -1 if second else 1]
        corners = flipped.swapaxes(0, 1) if swap else flipped
        axis, end = place(b.name)
        out = -unit(a.outward) * np.linalg.norm(b.outward)
        edges = [corners[1, 0] - corners[0, 0], corners[0, 1] - corners[0, 0]]
        edges.insert(axis, out if end else -out)
        low, high = domain_box(b.grid)
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack(edges, axis=1) / (high - low)
        matrix[:3, 3] = corners[0, 0] - (edges[axis] if end else 0.0) - matrix[:3, :3] @ low
        return matrix


def _built(grid: Grid, to_object: Array, name: str) -> isochor.Lattice:
    """The block with this transform. Raises ``Problem`` where it is flat."""
    try:
        return build_lattice(replace(grid, to_object=to_object))
    except isochor.LatticeError as error:
        raise problem.Problem(problem.flat_lattice(name)) from error


def _moved(grid: Grid, way: Array) -> Array:
    """The block's transform, moved in the world."""
    matrix = grid.to_object.copy()
    matrix[:3, 3] += way
    return matrix


def unit(vector: Array) -> Array:
    """The same direction, of length one."""
    return np.asarray(vector / np.linalg.norm(vector))
