# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeping the points of tied lattices together as they are edited: the one whose joint was touched last leads, and the
points of its neighbours are written after it.

What was touched is told from the stamps that the file keeps with each tie, not from what happened in this session: so
undo, redo and reopening a file find it out as well.
"""

from hashlib import blake2b
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.grid import Grid
from . import control, evaluated, node_group, sockets, stack, tie_points, tie_record, ties
from .tie_record import Tied

CLOSE = 1e-6
"""Distance, as a fraction of the lattice's box, below which a point is where it belongs."""
BASIS = "Bernstein"
"""Of lattices that no modifier uses yet."""


def settle(depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object]:
    """Has the neighbours of edited lattices follow; returns every lattice that hangs together with one of those that
    were evaluated anew. Nothing is written for a render, or while one runs."""
    if depsgraph.mode != "VIEWPORT":
        return []
    touched = [update.id.original for update in depsgraph.updates if _is_lattice(update)]
    tied = [lattice for lattice in touched if tie_record.is_tied(lattice)]
    if not tied:
        return []
    group = tie_record.connected(tied)
    if not bpy.app.is_job_running("RENDER"):
        bring_together(group, depsgraph)
    return group


def bring_together(group: list[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> None:
    """Finds who leads at each joint of these lattices, and writes the points of those that follow."""
    _Settling(group, depsgraph).run()


def basis_of(group: list[bpy.types.Object]) -> str:
    """What the modifiers say that use one of these lattices; the first item where none does."""
    for obj in stack.users(node_group.all_groups()):
        for modifier in stack.ours(obj):
            if sockets.read(modifier, sockets.LATTICE) in group:
                return str(sockets.read(modifier, "Basis"))
    return BASIS


class _Settling:
    """One round through lattices that hang together."""

    def __init__(self, group: list[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> None:
        self.group, self.depsgraph = group, depsgraph
        self.basis = basis_of(group)

    def run(self) -> None:
        """From those that were touched on to their neighbours, as far as anything changes."""
        waiting = [*self._touched(), *self._leading()]
        decided: set[frozenset[tuple[int, str]]] = set()
        # Each joint is decided once; where blocks stand in a ring, points at an edge may be written from two sides.
        rounds = len(waiting) + 2 * len(self.group)
        while waiting and rounds:
            lattice, rounds = waiting.pop(0), rounds - 1
            for tied in tie_record.of(lattice):
                if _name(tied) not in decided and self._is_touched(tied):
                    tie_record.lead(tied, True)
                    decided.add(_name(tied))
            for tied in tie_record.of(lattice):
                if tied.leads and self._write(tied.turned):
                    waiting.append(tied.other)
        for tied in [tied for lattice in self.group for tied in tie_record.of(lattice)]:
            tie_record.note(tied, self._stamp(tied))

    def _touched(self) -> list[bpy.types.Object]:
        """Those whose joints are others than when they last agreed; the active one first, then those in Edit Mode and
        the selected ones."""
        found = [one for one in self.group if any(map(self._is_touched, tie_record.of(one)))]
        active = bpy.context.view_layer.objects.active
        return sorted(found, key=lambda one: (one != active, one.mode != "EDIT", not one.select_get()))

    def _leading(self) -> list[bpy.types.Object]:
        """Those that lead somewhere, each after those that it follows itself, as far as there is such an order."""
        found, left = [], list(self.group)
        while left:
            free = (one for one in left if all(tied.leads or tied.other not in left for tied in tie_record.of(one)))
            chosen = next(free, left[0])
            left.remove(chosen)
            if any(tied.leads for tied in tie_record.of(chosen)):
                found.append(chosen)
        return found

    def _is_touched(self, tied: Tied) -> bool:
        return tied.stamp != self._stamp(tied)

    def _stamp(self, tied: Tied) -> str:
        """The same for the same points of this side's joint, and for no others."""
        types = evaluated.interpolation(tied.lattice) if self.basis == "Blender" else None
        grid = Grid(control.shape(tied.lattice), *evaluated.UNIT_BOX, self.basis, np.eye(4), types)
        mask = np.asarray(ties.mask(tied, grid).transpose(2, 1, 0)).reshape(-1)
        found = tie_points.sets(tied.lattice)
        digest = blake2b(repr((sorted(tie_points.values(tied.lattice).items()), grid.shape)).encode(), digest_size=12)
        for name in sorted(found):
            if len(found[name]) == len(mask):
                digest.update(name.encode() + found[name][mask].tobytes())
        return digest.hexdigest()

    def _write(self, tied: Tied) -> bool:
        """Writes the points of the lattice that the tie is seen from, which follows; whether any have changed."""
        try:
            changed = self._followed(tied)
        except problem.Problem:
            return False
        return tie_points.write(tied.lattice, changed)

    def _followed(self, tied: Tied) -> tie_points.Sets:
        """The sets of a follower that must change: with shape keys each as the leader's of the same name, or its first,
        has it; without, as the leader is shown."""
        own, others = tie_points.sets(tied.lattice), tie_points.sets(tied.other)
        keys = tied.other.data.shape_keys
        first = tie_points.PLAIN if keys is None else keys.reference_key.name
        changed: tie_points.Sets = {}
        for name, points in own.items():
            here = self._block(tied.lattice, points)
            if tied.lattice.data.shape_keys is None:
                there = self._shown(tied.other, others)
            else:
                there = self._block(tied.other, others.get(name, others[first]))
            found = ties.Block(here.grid, ties.joint(tied, here, there).follow(there.moved, here.moved, "b"))
            change = ties.local_change(here, found).reshape(-1, 3)
            if np.abs(change).max() > CLOSE:
                changed[name] = (points + change).astype(np.float32)
        return changed

    def _shown(self, lattice: bpy.types.Object, found: tie_points.Sets) -> ties.Block:
        """A leader as the viewport shows it, but without the modifiers that move its points, which move the follower's
        in their own way."""
        if tie_points.is_modified(lattice):
            return self._block(lattice, tie_points.mixed(lattice, found))
        return ties.resolved(lattice, self.basis, self.depsgraph)

    def _block(self, lattice: bpy.types.Object, points: NDArray[np.floating[Any]]) -> ties.Block:
        """A lattice with points (N, 3) where it is shown."""
        shown = lattice.evaluated_get(self.depsgraph)
        box = evaluated.lattice_points(shown).box
        flat = np.ascontiguousarray(points).reshape(-1)
        return ties.read(shown, evaluated.LatticePoints(control.shape(lattice), *box, flat), self.basis)


def _name(tied: Tied) -> frozenset[tuple[int, str]]:
    """The same from both sides."""
    return frozenset(((tied.lattice.session_uid, tied.face), (tied.other.session_uid, tied.other_face)))


def _is_lattice(update: bpy.types.DepsgraphUpdate) -> bool:
    moved = update.is_updated_geometry or update.is_updated_transform
    return moved and isinstance(update.id, bpy.types.Object) and update.id.type == "LATTICE"
