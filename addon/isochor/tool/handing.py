# SPDX-License-Identifier: GPL-3.0-or-later
"""Who of several Volume Lattices in a row corrects the volume: the last of them is enough, and exact for all."""

import bpy

from . import animated, chain, drivers, sockets

PRESERVE = "Preserve"
HANDED = (
    "Reference",
    "Target",
    PRESERVE,
    "Axes",
    "Space",
    sockets.FRAME,
    "Method",
    "Cost",
    sockets.WHERE_LOST,
    sockets.ISLANDS,
    sockets.REGION,
    sockets.REGION_TARGET,
    sockets.CLOSE_HOLES,
    sockets.UNFOLDED,
)
"""Inputs that say which volume is kept and how. Stiffness stays: its group belongs to one lattice."""


def to_last(obj: bpy.types.Object, new: bpy.types.NodesModifier) -> bpy.types.NodesModifier | None:
    """Has a new modifier correct in place of the one right before it; returns that one, or None where nothing is
    handed over, since it does not correct or its settings are animated."""
    before = chain.previous(obj, new)
    if before is None or sockets.read(before, PRESERVE) <= 0.0 or not _hand(obj, before, new):
        return None
    sockets.write(before, PRESERVE, 0.0)
    return before


def back(obj: bpy.types.Object, leaving: bpy.types.NodesModifier) -> None:
    """Before the last of a chain is taken away: the one before it, if it does not correct, does so in its place."""
    before = chain.previous(obj, leaving)
    is_last = chain.whole(obj, leaving)[-1] == leaving
    if before is not None and is_last and sockets.read(before, PRESERVE) <= 0.0:
        _hand(obj, leaving, before)


def _hand(obj: bpy.types.Object, giver: bpy.types.NodesModifier, taker: bpy.types.NodesModifier) -> bool:
    """Copies what says how the volume is kept; False, with nothing done, where keys or drivers say so."""
    known = [set(sockets.identifiers(modifier.node_group)) for modifier in (giver, taker)]
    names = [name for name in HANDED if all(name in found for found in known)]
    moving = animated.paths(obj)
    if any(drivers.data_path(modifier, name) in moving for modifier in (giver, taker) for name in names):
        return False
    for name in names:
        sockets.write(taker, name, sockets.read(giver, name))
    return True
