# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.apply."""

import bpy

from ..core.problem import Problem
from ..tool import applying, words
from .choosing import chosen_modifiers


class ISOCHOR_OT_apply(bpy.types.Operator):
    """Make the shape shown now the mesh's own, or a shape key of it, and take the Volume Lattice away"""

    bl_idname = "isochor.apply"
    bl_label = "Apply Volume Lattice"
    bl_options = {"REGISTER", "UNDO"}

    as_shape_key: bpy.props.BoolProperty(
        name="As Shape Key",
        description="Add the shape as a key, at 1, and leave the mesh's own shape as it is",
        options={"SKIP_SAVE"},
    )
    keep_modifier: bpy.props.BoolProperty(
        name="Keep Modifier",
        description="With a shape key: switch the Volume Lattice off in viewport and renders instead of removing it",
        options={"SKIP_SAVE"},
    )
    single_user: bpy.props.BoolProperty(
        name="Single User",
        description="Give an object that shares its mesh, or has it from another file, one of its own",
        options={"SKIP_SAVE"},
    )

    tolerance: bpy.props.FloatProperty(
        name="Tolerance",
        description="Split faces first, until edges are no farther than this from the deformed space; 0 splits none",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        subtype="DISTANCE",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set("Select an object with a Volume Lattice, or its lattice")
        return False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if any(applying.shared(obj) or not obj.data.is_editable for obj, _ in chosen_modifiers(context)):
            self.single_user = True
            return context.window_manager.invoke_confirm(
                self,
                event,
                title="Apply Volume Lattice",
                message="The mesh is shared, or comes from another file. Give the object one of its own and apply?",
                confirm_text="Apply",
            )
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        how = applying.How(self.as_shape_key, self.keep_modifier, self.single_user, self.tolerance)
        try:
            warnings = applying.apply(chosen_modifiers(context), how, context)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        for text in warnings:
            self.report({"WARNING"}, words.reported(text))
        return {"FINISHED"}


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_apply)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_apply)
