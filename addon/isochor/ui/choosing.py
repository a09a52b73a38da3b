# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects and modifiers an operator works on."""

import bpy

from ..tool import stack


def active_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object that the editor shows (a pinned one too), or the active one where a script runs outside of editors."""
    return getattr(context, "object", None) or context.view_layer.objects.active


def lattices_of_active(context: bpy.types.Context) -> list[bpy.types.NodesModifier]:
    """The Volume Lattice modifiers of the active object."""
    obj = active_object(context)
    return [] if obj is None else stack.ours(obj)


def chosen_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active mesh first, then the other selected ones; the active one alone where it is not selected."""
    active = active_object(context)
    meshes = [obj for obj in context.view_layer.objects.selected if obj.type == "MESH" and obj != active]
    return [active, *meshes] if active is not None and active.type == "MESH" else meshes
