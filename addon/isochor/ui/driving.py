# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators that put drivers have in common: which modifiers, which target, and what they refuse."""

import bpy

from ..tool import drivers, sockets
from .choosing import active_object, chosen_modifiers

Pairs = list[tuple[bpy.types.Object, bpy.types.NodesModifier]]

NOTHING_CHOSEN = "Select a mesh with a Volume Lattice, or its lattice"


class Refused(Exception):
    """Why an operator does nothing, in plain words."""


class Driving(bpy.types.Operator):
    """Base of the operators that put drivers on the inputs of the chosen modifiers"""

    bl_options = {"REGISTER", "UNDO"}

    replace: bpy.props.BoolProperty(
        name="Replace",
        description="Put it in the place of a driver that is already there and not the add-on's own",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set(NOTHING_CHOSEN)
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            self.put(context, chosen_modifiers(context))
        except Refused as reason:
            self.report({"ERROR"}, str(reason))
            return {"CANCELLED"}
        return {"FINISHED"}

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        """Puts the drivers; raises Refused before anything is changed."""
        raise NotImplementedError


def refuse_taken(pairs: Pairs, names: tuple[str, ...], replace: bool) -> None:
    """Raises Refused where an object belongs to another file, or an input is absent, keyed, or driven by others."""
    for obj, modifier in pairs:
        if not obj.is_editable:
            raise Refused(f"“{obj.name}” comes from another file: make it local or override it first")
        for name in names:
            refuse_input(obj, modifier, name, replace)


def refuse_input(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str, replace: bool) -> None:
    """Raises Refused where this one input cannot be driven."""
    if name not in sockets.identifiers(modifier.node_group):
        raise Refused(
            f"The Volume Lattice of “{obj.name}” comes from a file older than the input {name}: open and save that file"
        )
    path = drivers.data_path(modifier, name)
    if drivers.keys_of(obj, path) is not None:
        raise Refused(f"{name} of “{obj.name}” has keys, which a driver would hide: delete them first")
    curve = drivers.of(obj, path)
    if curve is not None and not replace and not drivers.is_own(curve):
        raise Refused(f"{name} of “{obj.name}” has a driver of yours already: delete it, or turn on Replace")


def target(
    context: bpy.types.Context, name: str, pairs: Pairs, what: str, kinds: tuple[str, ...] = ()
) -> bpy.types.Object:
    """The object called ``name``, or without a name the one that is selected beside the meshes and lattices of
    ``pairs``, of one of ``kinds`` where any are named. ``what``: the name of the operator's input for it."""
    if name:
        return named_target(name, what, kinds)
    found = beside(context, pairs, kinds)
    if len(found) == 1:
        return found[0]
    kind = f"an object of the kind {kinds[0].lower()}" if kinds else "one other object"
    told = f"found {', '.join(obj.name for obj in found)}" if found else "found none"
    raise Refused(f"{what}: select {kind} as well, or name it ({told})")


def named_target(name: str, what: str, kinds: tuple[str, ...]) -> bpy.types.Object:
    """The object of this name, refused where there is none of such a kind."""
    obj = bpy.data.objects.get(name)
    if obj is None:
        raise Refused(f"{what}: there is no object “{name}”; correct the name, or clear it and select the object")
    if kinds and obj.type not in kinds:
        raise Refused(f"{what}: “{name}” is of the kind {obj.type.lower()}; it must be {kinds[0].lower()}")
    return obj


def beside(context: bpy.types.Context, pairs: Pairs, kinds: tuple[str, ...]) -> list[bpy.types.Object]:
    """The active and selected objects that are neither the meshes of ``pairs`` nor their lattices."""
    ours = {obj for obj, _modifier in pairs} | {sockets.read(modifier, sockets.LATTICE) for _obj, modifier in pairs}
    chosen = list(context.view_layer.objects.selected)
    active = active_object(context)
    if active is not None and active not in chosen:
        chosen.append(active)
    return [obj for obj in chosen if obj not in ours and (not kinds or obj.type in kinds)]


def search_objects(_operator: object, _context: bpy.types.Context, typed: str) -> list[str]:
    """Names of objects that hold what was typed."""
    return [obj.name for obj in bpy.data.objects if typed.lower() in obj.name.lower()]
