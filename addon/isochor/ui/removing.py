# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.remove."""

import bpy

from ..tool import removing, words
from .choosing import chosen_modifiers


class ISOCHOR_OT_remove(bpy.types.Operator):
    """Take the Volume Lattice of every selected mesh away, with its lattice if nothing else uses it; with a lattice
    selected, those of all meshes that use it"""

    bl_idname = "isochor.remove"
    bl_label = "Remove Volume Lattice"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set("The selected objects have no Volume Lattice")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = chosen_modifiers(context)
        refusals = [text for text in (removing.refusal(*pair) for pair in pairs) if text]
        if refusals:
            self.report({"ERROR"}, words.reported(refusals[0]))
            return {"CANCELLED"}
        for obj, modifier in pairs:
            removing.remove(obj, modifier)
        return {"FINISHED"}


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_remove)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_remove)
