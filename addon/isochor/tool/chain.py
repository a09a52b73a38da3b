# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume Lattices that stand right behind one another on one object: they are corrected as one, by the last."""

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.bodies import Bodies, volumes
from ..core.request import Vertices
from . import results, stack


@dataclass(frozen=True)
class Chain:
    """Those before the one that is computed: the ``last`` of them, what ``entered`` the first, what entered the first
    of those behind the last one that corrected (``since``), and what is ``leaving`` the last, each (V, 3)."""

    last: bpy.types.NodesModifier
    entered: Vertices
    since: Vertices
    leaving: Vertices

    def incoming(self, triangles: NDArray[np.int32] | None, bodies: Bodies | None) -> tuple[float, ...] | None:
        """Signed volume of each body of what entered in this frame, where what enters the next is another, since those
        between have not corrected; None where it is the same."""
        if triangles is None or self.since is self.leaving:
            return None
        return tuple(map(float, volumes(self.since, triangles, bodies)))

    def kept(self, mode: str) -> bpy.types.Object | None:
        """What holds the volumes at rest of the one before, in a depsgraph mode."""
        return results.of(self.last, mode)


def longer(
    before: Chain | None,
    modifier: bpy.types.NodesModifier,
    entered: Vertices | None,
    leaving: Vertices | None,
    corrected: bool,
) -> Chain | None:
    """The chain with one more, and whether that corrected; None where it is not known what left that."""
    if entered is None or leaving is None:
        return None
    first = entered if before is None else before.entered
    since = leaving if corrected else entered if before is None else before.since
    return Chain(modifier, first, since, leaving)


def previous(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> bpy.types.NodesModifier | None:
    """The Volume Lattice right before this one in the stack."""
    place = list(obj.modifiers).index(modifier)
    before = obj.modifiers[place - 1] if place else None
    return before if before is not None and stack.is_ours(before) else None


def whole(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[bpy.types.NodesModifier]:
    """All that stand in one chain with this one, itself too, in stack order."""
    found = [modifier]
    while (before := previous(obj, found[0])) is not None:
        found.insert(0, before)
    for other in obj.modifiers[list(obj.modifiers).index(modifier) + 1 :]:
        if not stack.is_ours(other):
            break
        found.append(other)
    return found


def whole_of_all(
    pairs: list[tuple[bpy.types.Object, bpy.types.NodesModifier]],
) -> list[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """These and all that stand in a chain with one of them, each once, those of one chain in stack order."""
    found = {
        (obj.session_uid, member.persistent_uid): (obj, member) for obj, one in pairs for member in whole(obj, one)
    }
    return list(found.values())
