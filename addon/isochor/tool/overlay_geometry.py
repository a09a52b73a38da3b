# SPDX-License-Identifier: GPL-3.0-or-later
"""What there is to draw of each Volume Lattice in a view, worked out anew only where its report has changed."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import bpy
import numpy as np

import isochor

from ..core.grid import build_lattice
from ..core.isolines import Drawing, Wanted, drawing, lengths
from ..core.report import Report
from . import node_group, sockets, stack, state

Key = tuple[int, int]
"""Session identifier of the object, identifier of the modifier in it."""


class Fold(Enum):
    """What to do about folds: leave them alone, tell those that are known, or look for them."""

    LEAVE = 0
    RECALL = 1
    COMPUTE = 2


@dataclass(frozen=True)
class Shown:
    """One modifier in one view: its drawing (the very same object until its report changes), the 4x4 matrix of its
    object to world as evaluated, the largest displacement of a control point in world units, and where it folds over,
    if that was asked for (the very same object until the lattice's shape changes)."""

    key: Key
    drawing: Drawing
    to_world: Any
    largest: float
    folds: isochor.Folds | None = None


@dataclass(frozen=True)
class _Made:
    """A drawing and all that it was made from; of arrays and results, it is enough that they are the same objects."""

    source: tuple[object, ...]
    wanted: Wanted | None
    drawing: Drawing


_made: dict[Key, _Made] = {}


def modifiers_in_view(
    view_layer: bpy.types.ViewLayer, visible: Callable[[bpy.types.Object], bool], only_selected: bool
) -> list[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every Volume Lattice that is on, of objects that are visible; where asked, of those only that are active or
    selected or whose lattice is."""
    groups = node_group.all_groups()
    chosen = {view_layer.objects.active, *view_layer.objects.selected}
    return [
        (obj, modifier)
        for obj in stack.users(groups)
        if visible(obj)
        for modifier in stack.ours(obj)
        if stack.is_on(modifier, "VIEWPORT")
        and (not only_selected or obj in chosen or sockets.read(modifier, sockets.LATTICE) in chosen)
    ]


def shown(
    pairs: list[tuple[bpy.types.Object, bpy.types.NodesModifier]],
    depsgraph: bpy.types.Depsgraph,
    wanted: Wanted | None,
    fold: Fold = Fold.LEAVE,
) -> list[Shown]:
    """What there is to draw of these modifiers; nothing of those that were not computed."""
    found = []
    for obj, modifier in pairs:
        memory = state.recall(obj, modifier)
        key = obj.session_uid, modifier.persistent_uid
        made = None if memory is None else drawing_of(key, memory.report, wanted)
        if memory is not None and made is not None:
            to_world = obj.evaluated_get(depsgraph).matrix_world.copy()
            moved = lengths(made.moved, np.array(to_world, np.float64))
            folds = None if fold is Fold.LEAVE else memory.folding.of(memory.report, fold is Fold.COMPUTE)
            found.append(Shown(key, made, to_world, float(moved.max(initial=0.0)), folds))
    return found


def drawing_of(key: Key, report: Report, wanted: Wanted | None) -> Drawing | None:
    """The drawing of a report, or None where it says nothing about a lattice; the same as before for the same one."""
    if report.grid is None or report.asked is None or report.control is None:
        _made.pop(key, None)
        return None
    source = (report.grid, report.asked, report.result)
    before = _made.get(key)
    same = before is not None and all(one is other for one, other in zip(source, before.source, strict=True))
    if before is not None and same and wanted == before.wanted:
        return before.drawing
    shaped = report.bound is not None and report.bound.is_shaped
    made = drawing(build_lattice(report.grid), report.asked, report.control, wanted, shaped)
    _made[key] = _Made(source, wanted, made)
    return made


def keys_of_file() -> set[Key]:
    """Of every Volume Lattice that there is."""
    users = stack.users(node_group.all_groups())
    return {(obj.session_uid, modifier.persistent_uid) for obj in users for modifier in stack.ours(obj)}


def forget_all_but(keys: set[Key]) -> None:
    """Lets go of the drawings of what is no longer in the file."""
    for key in _made.keys() - keys:
        del _made[key]
