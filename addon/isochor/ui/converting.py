# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.convert."""

import bpy

from ..core.problem import Problem
from ..tool import adding, converting, words
from .choosing import active_object


class ISOCHOR_OT_convert(bpy.types.Operator):
    """Replace Blender's own Lattice modifiers of the selected objects, or those of a selected lattice, by Volume
    Lattices. Nothing visible changes; raise Preserve to keep the volume then"""

    bl_idname = "isochor.convert"
    bl_label = "Convert Lattice Modifiers"
    bl_options = {"REGISTER", "UNDO"}

    preserve: bpy.props.BoolProperty(
        name="Preserve", description="Keep the volume from now on, which changes the shape", options={"SKIP_SAVE"}
    )
    only_active: bpy.props.BoolProperty(
        name="Only Active",
        description="Of each object, replace the active modifier alone",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if any(converting.native(obj) for obj in _objects(context)):
            return True
        cls.poll_message_set("Select an object with Blender's own Lattice modifier, or its lattice, first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = [(obj, modifier) for obj in _objects(context) for modifier in converting.native(obj)]
        if self.only_active:
            pairs = [(obj, modifier) for obj, modifier in pairs if obj.modifiers.active == modifier]
        try:
            converting.refuse(pairs)
            warnings = converting.convert(pairs, self.preserve, context)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if adding.lock_interface(context.scene):
            self.report({"INFO"}, "Lock Interface is now on in the Render menu: renders need it")
        for text in warnings:
            self.report({"WARNING"}, words.reported(text))
        return {"FINISHED"} if pairs else {"CANCELLED"}


def _objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Every active or selected object, and of a lattice those that Blender's own modifier deforms by it; each once."""
    active = active_object(context)
    chosen = [active, *(obj for obj in context.view_layer.objects.selected if obj != active)]
    found = []
    for obj in chosen:
        if obj is not None:
            found += converting.users_of(obj) if obj.type == "LATTICE" else [obj]
    return list(dict.fromkeys(found))


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_convert)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_convert)
