# SPDX-License-Identifier: GPL-3.0-or-later
"""Ties between lattices as one evaluation sees them: the points that follow a neighbour's, those that the correction
must leave alone, and which vertices belong to which of the blocks side by side."""

from dataclasses import dataclass, replace
from functools import lru_cache

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem, sharing
from ..core.grid import Grid
from ..core.settings import Settings
from ..core.tie import Face, Tie
from . import evaluated, sockets, stack, tie_record
from .evaluated import LatticePoints
from .tie_record import Tied

Array = NDArray[np.float64]
Moved = NDArray[np.float64]
"""(nu, nv, nw, 3) displacements in the world."""

ROUNDING = 2e-7
"""Displacement, as a fraction of the undeformed grid, that is none: Blender's sums along a fine grid are so far off."""


@dataclass(frozen=True)
class Block:
    """A lattice as evaluated: its undeformed ``grid`` in the world, and how far its points have ``moved``."""

    grid: Grid
    moved: Moved


def grid_of(lattice: bpy.types.Object, points: LatticePoints, basis: str) -> Grid:
    """An evaluated lattice, undeformed, in the world."""
    types = evaluated.interpolation(lattice) if basis == "Blender" else None
    return Grid(points.shape, points.low, points.high, basis, evaluated.matrix(lattice), types)


def read(lattice: bpy.types.Object, points: LatticePoints, basis: str) -> Block:
    """The block of an evaluated lattice with these points."""
    grid = grid_of(lattice, points, basis)
    return Block(grid, _from_flat(_displaced(points), points.shape) @ grid.to_object[:3, :3].T)


def followed(
    lattice: bpy.types.Object, points: LatticePoints, settings: Settings, depsgraph: bpy.types.Depsgraph
) -> tuple[LatticePoints, list[str]]:
    """The points of an evaluated lattice, with those at joints where a neighbour leads as the neighbour has them, and
    what is wrong with ties."""
    ties = tie_record.of(lattice.original)
    if not ties:
        return points, []
    block = read(lattice, points, settings.basis)
    found, problems = _resolve(lattice.original, block, depsgraph, frozenset())
    if not settings.shaping.is_neutral:
        problems.append(problem.tied_and_animated(lattice.name))
    if settings.weights:
        problems.append(problem.tied_and_weighted(lattice.name))
    return replace(points, deformed=_undeformed(points) + _displaced(points) + local_change(block, found)), problems


def local_change(block: Block, found: Block) -> Array:
    """(N * 3,) u fastest, in lattice space: from one state of a block to another."""
    return _to_flat((found.moved - block.moved) @ np.linalg.inv(block.grid.to_object[:3, :3]).T)


def stiffened(stiffness: Array | None, lattice: bpy.types.Object, grid: Grid, beyond: tuple[str, ...]) -> Array | None:
    """(nu, nv, nw) with the points that make the joints of an evaluated lattice stiff altogether, and those at faces
    beyond which vertices lie that are kept: the correction must part neither."""
    masks = [mask(tied, grid) for tied in tie_record.of(lattice.original)]
    masks += [Face(grid, face).held(0) for face in beyond]
    if not masks:
        return stiffness
    return np.where(np.logical_or.reduce(masks), 1.0, 0.0 if stiffness is None else stiffness)


def resolved(
    lattice: bpy.types.Object, basis: str, depsgraph: bpy.types.Depsgraph, done: frozenset[int] = frozenset()
) -> Block:
    """The block of an original lattice with what it follows. Raises ``Problem`` where it is not evaluated."""
    shown = lattice.evaluated_get(depsgraph)
    if not shown.is_evaluated:
        raise problem.Problem(problem.hidden(lattice.name))
    return _resolve(lattice, read(shown, evaluated.lattice_points(shown), basis), depsgraph, done)[0]


def joint(tied: Tied, here: Block, there: Block) -> Tie:
    """The tie between two blocks; the lattice that it is seen from is "a"."""
    a, b = Face(here.grid, tied.face), Face(there.grid, tied.other_face)
    return Tie(a, b, tied.continuity, (tied.lattice.name, tied.other.name))


def mask(tied: Tied, grid: Grid) -> NDArray[np.bool_]:
    """(nu, nv, nw) the points of this side of a tie that make the joint."""
    return Face(grid, tied.face).held(tied.continuity)


def widened(lattice: bpy.types.Object, transform: Array, box: evaluated.Box) -> Array:
    """The transform of an evaluated lattice into the space of a mesh: of a tied one ``core.sharing.widened``."""
    return sharing.widened(transform, box) if tie_record.is_tied(lattice.original) else transform


def beside(
    modifiers: list[bpy.types.Modifier], modifier: bpy.types.NodesModifier
) -> list[tuple[bpy.types.NodesModifier, bpy.types.Object]]:
    """The modifiers in one row with this one, itself too, whose lattices hang together with its own by ties; none
    where it is alone."""
    lattice = _lattice_of(modifier)
    if lattice is None or not tie_record.is_tied(lattice):
        return []
    group = {other.session_uid for other in tie_record.connected([lattice])}
    found = [(other, _lattice_of(other)) for other in _row(modifiers, modifier)]
    blocks = [(other, block) for other, block in found if block is not None and block.session_uid in group]
    return blocks if len(blocks) > 1 else []


def _resolve(
    lattice: bpy.types.Object, block: Block, depsgraph: bpy.types.Depsgraph, done: frozenset[int]
) -> tuple[Block, list[str]]:
    problems = []
    done |= {lattice.session_uid}
    for tied in tie_record.of(lattice):
        if tied.leads or tied.other.session_uid in done:
            continue
        try:
            leader = resolved(tied.other, block.grid.basis, depsgraph, done)
            block = replace(block, moved=joint(tied, block, leader).follow(leader.moved, block.moved, "b"))
        except problem.Problem as trouble:
            problems.append(trouble.sentence)
    return block, problems


def _lattice_of(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    lattice = sockets.read(modifier, sockets.LATTICE)
    return lattice if lattice is not None and lattice.type == "LATTICE" else None


def _row(modifiers: list[bpy.types.Modifier], modifier: bpy.types.NodesModifier) -> list[bpy.types.NodesModifier]:
    """Volume Lattices right before and behind this one, and itself."""
    first = last = modifiers.index(modifier)
    while first > 0 and stack.is_ours(modifiers[first - 1]):
        first -= 1
    while last + 1 < len(modifiers) and stack.is_ours(modifiers[last + 1]):
        last += 1
    return modifiers[first : last + 1]


def _undeformed(points: LatticePoints) -> Array:
    """(N * 3,) u fastest, in lattice space."""
    return _spaced(points.shape, points.low, points.high)


@lru_cache(maxsize=64)
def _spaced(shape: tuple[int, int, int], low: tuple[float, ...], high: tuple[float, ...]) -> Array:
    axes = [np.linspace(start, end, count) for start, end, count in zip(low, high, shape, strict=True)]
    found = _to_flat(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    found.setflags(write=False)
    return found


def _displaced(points: LatticePoints) -> Array:
    """The same, from there to where they are; nothing where that is rounding alone."""
    found = points.deformed.astype(np.float64) - _undeformed(points)
    size = np.subtract(points.high, points.low).max()
    return np.where(np.abs(found) <= ROUNDING * (size if size > 0.0 else 1.0), 0.0, found)


def _from_flat(values: Array, shape: tuple[int, int, int]) -> Array:
    u, v, w = shape
    return np.ascontiguousarray(values.reshape(w, v, u, 3).transpose(2, 1, 0, 3))


def _to_flat(values: Array) -> Array:
    return np.ascontiguousarray(values.transpose(2, 1, 0, 3)).reshape(-1)
