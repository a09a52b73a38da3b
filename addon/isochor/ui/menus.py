# SPDX-License-Identifier: GPL-3.0-or-later
"""Where isochor.add stands in Blender's menus."""

import bpy

from .operators import ISOCHOR_OT_add


def draw_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """One line in Add Modifier, Deform, and in the Object menu of the 3D View."""
    menu.layout.operator(ISOCHOR_OT_add.bl_idname, text="Volume Lattice", icon="MOD_LATTICE")


MENUS = ("OBJECT_MT_modifier_add_deform", "VIEW3D_MT_object")


def register() -> None:
    """Adds the entries."""
    for name in MENUS:
        getattr(bpy.types, name).append(draw_entry)


def unregister() -> None:
    """Takes them out, last first."""
    for name in reversed(MENUS):
        getattr(bpy.types, name).remove(draw_entry)
