# SPDX-License-Identifier: GPL-3.0-or-later
"""Taking a Volume Lattice away without a trace."""

import bpy

from ..core import problem
from . import (
    adding,
    animation_paths,
    baked,
    baked_lattice,
    handing,
    lattices,
    node_group,
    pin_collection,
    results,
    speed,
    stack,
)


def remove(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> None:
    """Removes the modifier with its keys and drivers, its result meshes, a bake that plays in its place, the lattice
    and the pins that were made for it if nothing else uses them, and the node group with its last user. Where it was
    the one of several that keeps the volume, the one before does so from now on."""
    if baked.is_playing(obj):
        baked.switch_back(obj)
    handing.back(obj, modifier)
    lattice = lattices.of(modifier)
    pin_collection.take_away(modifier, bpy.context.scene)
    results.remove(modifier)
    animation_paths.remove(obj, [animation_paths.of_modifier(modifier)])
    obj.modifiers.remove(modifier)
    if not stack.ours(obj):
        speed.forget(obj)
    if lattice is not None and adding.MADE_BY_ADD in lattice and lattice.library is None:
        _remove_unused(lattice)
    if not stack.users(node_group.all_groups()):
        for group in node_group.all_groups():
            if group.users == 0 and group.library is None:
                bpy.data.node_groups.remove(group)


def refusal(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    """Why the modifier cannot be taken away, in plain words; empty where it can."""
    if not obj.is_editable:
        return problem.foreign(obj.name)
    if obj.override_library is not None and modifier.is_override_data:
        return problem.modifier_of_library(obj.name, modifier.name)
    return ""


def _remove_unused(lattice: bpy.types.Object) -> None:
    if lattices.is_used(lattice):
        return
    if baked_lattice.is_baked(lattice):
        baked_lattice.remove(baked_lattice.free(lattice))
    data = lattice.data
    bpy.data.objects.remove(lattice)
    if data is not None and data.users == 0:
        bpy.data.lattices.remove(data)
