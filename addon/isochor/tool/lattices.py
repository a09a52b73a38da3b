# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lattice object shapes a modifier, which modifiers a lattice shapes, and whether anything else needs it."""

import bpy

from . import node_group, sockets, stack, tie_record

Pair = tuple[bpy.types.Object, bpy.types.NodesModifier]


def of(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The lattice object that the modifier names, or None where it names none."""
    lattice = sockets.read(modifier, sockets.LATTICE)
    return lattice if lattice is not None and lattice.type == "LATTICE" else None


def of_all(pairs: list[Pair]) -> list[bpy.types.Object]:
    """The lattices that shape these modifiers, each once."""
    found = (of(modifier) for _obj, modifier in pairs)
    return list(dict.fromkeys(lattice for lattice in found if lattice is not None))


def users_of(lattice: bpy.types.Object) -> list[Pair]:
    """Every object with a modifier that this lattice shapes, in order of name."""
    users = stack.users(node_group.all_groups())
    pairs = [(obj, modifier) for obj in users for modifier in stack.ours(obj)]
    return [(obj, modifier) for obj, modifier in pairs if sockets.read(modifier, sockets.LATTICE) == lattice]


def is_used(lattice: bpy.types.Object) -> bool:
    """Whether anything but the collections that show it, and the blocks that it is tied to, refers to the object."""
    users = bpy.data.user_map(subset=[lattice])[lattice]
    tied = [tie.other for tie in tie_record.of(lattice) if not _names(tie.other, lattice)]
    beside = {lattice, *tied}
    return any(not isinstance(user, (bpy.types.Collection, bpy.types.Scene)) and user not in beside for user in users)


def _names(other: bpy.types.Object, lattice: bpy.types.Object) -> bool:
    """Whether another lattice object needs this one in one of Blender's own ways."""
    return other.parent == lattice or any(getattr(found, "object", None) == lattice for found in other.modifiers)
