# SPDX-License-Identifier: GPL-3.0-or-later
"""Taking a Volume Lattice away without a trace."""

import bpy

from . import adding, baked_lattice, node_group, results, sockets, stack


def remove(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> None:
    """Removes the modifier, its result meshes, the lattice that isochor.add made for it if nothing else uses it, and
    the node group with its last user."""
    lattice = sockets.read(modifier, sockets.LATTICE)
    results.remove(modifier)
    obj.modifiers.remove(modifier)
    if lattice is not None and adding.MADE_BY_ADD in lattice and not _is_used(lattice):
        if baked_lattice.is_baked(lattice):
            baked_lattice.remove(baked_lattice.free(lattice))
        data = lattice.data
        bpy.data.objects.remove(lattice)
        if data is not None and data.users == 0:
            bpy.data.lattices.remove(data)
    if not stack.users(node_group.all_groups()):
        for group in node_group.all_groups():
            if group.users == 0:
                bpy.data.node_groups.remove(group)


def _is_used(lattice: bpy.types.Object) -> bool:
    """Whether anything but the collections that show it refers to the object."""
    users = bpy.data.user_map(subset=[lattice])[lattice]
    return any(not isinstance(user, (bpy.types.Collection, bpy.types.Scene)) and user != lattice for user in users)
