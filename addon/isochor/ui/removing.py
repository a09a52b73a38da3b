# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.remove."""

import bpy

from ..tool import removing
from .choosing import lattices_of_active


class ISOCHOR_OT_remove(bpy.types.Operator):
    """Take the Volume Lattice away, with its lattice if nothing else uses it"""

    bl_idname = "isochor.remove"
    bl_label = "Remove Volume Lattice"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if lattices_of_active(context):
            return True
        cls.poll_message_set("The active object has no Volume Lattice")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        modifiers = lattices_of_active(context)
        obj = modifiers[0].id_data
        active = obj.modifiers.active
        removing.remove(obj, active if active in modifiers else modifiers[-1])
        return {"FINISHED"}


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_remove)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_remove)
