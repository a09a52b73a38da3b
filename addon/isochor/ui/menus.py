# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the operators stand in Blender's menus."""

import bpy

from .adding import ISOCHOR_OT_add
from .removing import ISOCHOR_OT_remove
from .simulating import ISOCHOR_OT_free_simulation, ISOCHOR_OT_simulate

ENTRIES = (
    (ISOCHOR_OT_add.bl_idname, "MOD_LATTICE"),
    (ISOCHOR_OT_simulate.bl_idname, "PHYSICS"),
    (ISOCHOR_OT_free_simulation.bl_idname, "LOOP_BACK"),
    (ISOCHOR_OT_remove.bl_idname, "X"),
)
"""Operator and icon of each line of Object, Volume Lattice."""


class VIEW3D_MT_isochor(bpy.types.Menu):
    """Everything that can be done with a Volume Lattice"""

    bl_label = "Volume Lattice"

    def draw(self, _context: bpy.types.Context) -> None:
        for operator, icon in ENTRIES:
            self.layout.operator(operator, icon=icon)


def draw_modifier_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """One line in Add Modifier, Deform."""
    menu.layout.operator(ISOCHOR_OT_add.bl_idname, text="Volume Lattice", icon="MOD_LATTICE")


def draw_object_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """A menu of our own in the Object menu of the 3D View."""
    menu.layout.menu(VIEW3D_MT_isochor.__name__, icon="MOD_LATTICE")


PLACES = (("OBJECT_MT_modifier_add_deform", draw_modifier_entry), ("VIEW3D_MT_object", draw_object_entry))


def register() -> None:
    """Adds the entries."""
    bpy.utils.register_class(VIEW3D_MT_isochor)
    for name, draw in PLACES:
        getattr(bpy.types, name).append(draw)


def unregister() -> None:
    """Takes them out, last first."""
    for name, draw in reversed(PLACES):
        getattr(bpy.types, name).remove(draw)
    bpy.utils.unregister_class(VIEW3D_MT_isochor)
