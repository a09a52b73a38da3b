# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects and modifiers an operator works on."""

import bpy

from ..tool import stack
from ..tool.lattices import of_all, users_of


def active_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object that the editor shows (a pinned one too), or the active one where a script runs outside of editors."""
    return getattr(context, "object", None) or context.view_layer.objects.active


def chosen_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """What can be deformed: the active object first, then the other selected ones; the active one alone where it is not
    selected."""
    active = active_object(context)
    found = [obj for obj in context.view_layer.objects.selected if obj.type in stack.DEFORMED and obj != active]
    return [active, *found] if active is not None and active.type in stack.DEFORMED else found


def chosen_modifiers(context: bpy.types.Context) -> list[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """The Volume Lattice that is meant of each active or selected object, and all that use an active or selected
    lattice, each once: of an object with several, the active one, or the last where another modifier is active."""
    view = context.view_layer.objects
    active = active_object(context)
    chosen = [active, *(obj for obj in view.selected if obj != active)] if active is not None else list(view.selected)
    found = {}
    for obj in chosen:
        if obj.type in stack.DEFORMED and stack.ours(obj):
            modifiers = stack.ours(obj)
            meant = obj.modifiers.active if obj.modifiers.active in modifiers else modifiers[-1]
            found[obj.session_uid, meant.persistent_uid] = (obj, meant)
        elif obj.type == "LATTICE":
            for user, modifier in users_of(obj):
                found[user.session_uid, modifier.persistent_uid] = (user, modifier)
    return list(found.values())


def chosen_lattices(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Every active or selected lattice, and those that shape an active or selected object, each once."""
    active = active_object(context)
    chosen = [active, *(obj for obj in context.view_layer.objects.selected if obj != active)]
    lattices = [obj for obj in chosen if obj is not None and obj.type == "LATTICE"]
    return list(dict.fromkeys([*lattices, *of_all(chosen_modifiers(context))]))
