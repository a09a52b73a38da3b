# SPDX-License-Identifier: GPL-3.0-or-later
"""Tying lattices whose faces coincide, and untying them."""

from itertools import combinations
from typing import NamedTuple

import bpy
import numpy as np

from ..core import problem
from ..core.grid import Grid
from ..core.tie import Face, meets, nearest_faces
from . import baked_lattice, evaluated, lattices, sockets, tie_record, tie_settling, ties
from .tie_record import Tied


class Pair(NamedTuple):
    """Two lattices and their nearest faces, so far apart."""

    gap: float
    one: bpy.types.Object
    face: str
    other: bpy.types.Object
    other_face: str


def tie(
    chosen: list[bpy.types.Object], continuity: int, context: bpy.types.Context
) -> tuple[list[Tied], list[bpy.types.Object]]:
    """Ties all of these lattices that meet; the first leads. Returns the ties, and the lattices that meet none of the
    others. Raises ``Problem``, with nothing changed, where one cannot be tied, or none meet."""
    for lattice in chosen:
        _refuse(lattice)
    basis = _basis(chosen)
    depsgraph = context.evaluated_depsgraph_get()
    grids = {lattice: grid_of(lattice, basis, depsgraph) for lattice in chosen}
    pairs = sorted((_pair(*two, grids) for two in combinations(chosen, 2)), key=lambda pair: pair.gap)
    found = [pair for pair in pairs if meets(pair.gap, grids[pair.one], pair.face)]
    if not found:
        nearest = pairs[0]
        raise problem.Problem(problem.apart(nearest.one.name, nearest.other.name, nearest.gap))
    made = _from_leader(found, chosen[0], continuity)
    for tied in made:
        ties.joint(tied, *(ties.Block(grids[side], np.zeros(0)) for side in (tied.lattice, tied.other)))
    for lattice in chosen:
        _refuse_crowded(lattice, grids[lattice], [side for one in made for side in (one, one.turned)])
    for tied in made:
        tie_record.keep(tied)
    tie_settling.bring_together(tie_record.connected(chosen), depsgraph)
    tag(chosen, context)
    met = {lattice for pair in found for lattice in (pair.one, pair.other)}
    return made, [lattice for lattice in chosen if lattice not in met]


def untie(chosen: list[bpy.types.Object], context: bpy.types.Context) -> list[Tied]:
    """Takes away the ties between these lattices; of a single one, all that it has. Returns those that were."""
    found = {}
    for tied in (tied for lattice in chosen for tied in tie_record.of(lattice)):
        if len(chosen) == 1 or tied.other in chosen:
            found[frozenset(((tied.lattice, tied.face), (tied.other, tied.other_face)))] = tied
    beside = [side.lattice for tied in found.values() for side in (tied, tied.turned)]
    for tied in found.values():
        if not tied.lattice.is_editable or not tied.other.is_editable:
            raise problem.Problem(problem.foreign(tied.lattice.name))
    for tied in found.values():
        tie_record.forget(tied)
    tag(beside, context)
    return list(found.values())


def grid_of(lattice: bpy.types.Object, basis: str, depsgraph: bpy.types.Depsgraph) -> Grid:
    """The undeformed lattice in the world."""
    shown = lattice.evaluated_get(depsgraph)
    if not shown.is_evaluated:
        raise problem.Problem(problem.hidden(lattice.name))
    points = evaluated.lattice_points(shown)
    if abs(np.linalg.det(evaluated.matrix(shown)[:3, :3])) == 0.0:
        raise problem.Problem(problem.flat_lattice(lattice.name))
    return ties.grid_of(shown, points, basis)


def tag(chosen: list[bpy.types.Object], context: bpy.types.Context) -> None:
    """Has the meshes that these lattices shape computed anew."""
    for lattice in chosen:
        for obj, _modifier in lattices.users_of(lattice):
            obj.update_tag(refresh={"DATA"})
    context.view_layer.update()


def _refuse(lattice: bpy.types.Object) -> None:
    if not lattice.is_editable:
        raise problem.Problem(problem.foreign(lattice.name))
    if baked_lattice.is_baked(lattice):
        raise problem.Problem(problem.simulated(lattice.name))


def _basis(chosen: list[bpy.types.Object]) -> str:
    """The one that the modifiers of all these lattices have."""
    first: dict[str, bpy.types.Object] = {}
    for lattice in chosen:
        for _obj, modifier in lattices.users_of(lattice):
            first.setdefault(str(sockets.read(modifier, "Basis")), lattice)
    if len(first) > 1:
        raise problem.Problem(problem.tied_bases(*(lattice.name for lattice in list(first.values())[:2])))
    return next(iter(first), tie_settling.BASIS)


def _pair(one: bpy.types.Object, other: bpy.types.Object, grids: dict[bpy.types.Object, Grid]) -> Pair:
    gap, face, other_face = nearest_faces(grids[one], grids[other])
    if not face:
        raise problem.Problem(problem.apart(one.name, other.name, gap))
    return Pair(gap, one, face, other, other_face)


def _from_leader(found: list[Pair], leader: bpy.types.Object, continuity: int) -> list[Tied]:
    """The ties, each led by the side that is nearer to the leader, counted in blocks; every face in one at most."""
    made, reached, left = [], [leader], list(found)
    taken: set[tuple[bpy.types.Object, str]] = set()
    while left:
        pair = next((one for one in left if one.one in reached or one.other in reached), left[0])
        left.remove(pair)
        sides = {(pair.one, pair.face), (pair.other, pair.other_face)}
        if sides & taken:
            continue
        taken |= sides
        leads = pair.one in reached and (pair.other not in reached or _before(reached, pair.one, pair.other))
        made.append(Tied(pair.one, pair.face, pair.other, pair.other_face, continuity, leads))
        reached += [lattice for lattice in (pair.one, pair.other) if lattice not in reached]
    return made


def _before(reached: list[bpy.types.Object], one: bpy.types.Object, other: bpy.types.Object) -> bool:
    return reached.index(one) < reached.index(other)


def _refuse_crowded(lattice: bpy.types.Object, grid: Grid, made: list[Tied]) -> None:
    """Raises ``Problem`` where two opposite joints of a block would hold the same points."""
    new = {tied.face: tied for tied in made if tied.lattice == lattice}
    held = {**{tied.face: tied for tied in tie_record.of(lattice)}, **new}
    for axis in "stu":
        low, high = held.get(f"{axis}0"), held.get(f"{axis}1")
        if low is not None and high is not None and np.any(ties.mask(low, grid) & ties.mask(high, grid)):
            need = 2 * Face(grid, low.face).layers(low.continuity)
            raise problem.Problem(problem.tied_crowded(lattice.name, "UVW"["stu".index(axis)], need))
