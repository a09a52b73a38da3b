# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the operators stand in Blender's menus."""

import bpy

from .adding import ISOCHOR_OT_add
from .applying import ISOCHOR_OT_apply
from .baking import ISOCHOR_OT_bake, ISOCHOR_OT_free_bake
from .bend_empty import ISOCHOR_OT_bend_from_empty
from .binding import ISOCHOR_OT_clear_rest, ISOCHOR_OT_set_rest
from .converting import ISOCHOR_OT_convert
from .fitting import ISOCHOR_OT_fit_lattice
from .measuring import ISOCHOR_OT_measure_volume
from .mirroring import ISOCHOR_OT_mirror_lattice
from .pinning import ISOCHOR_OT_add_pin, ISOCHOR_OT_bind_pins, ISOCHOR_OT_remove_pins
from .points import ISOCHOR_OT_bake_points, ISOCHOR_OT_deform_points, ISOCHOR_OT_restore_points
from .refining import ISOCHOR_OT_refine
from .removing import ISOCHOR_OT_remove
from .simulating import ISOCHOR_OT_free_simulation, ISOCHOR_OT_simulate
from .squash_ground import ISOCHOR_OT_squash_from_ground
from .squash_speed import ISOCHOR_OT_squash_from_speed
from .twist_bone import ISOCHOR_OT_twist_from_bone
from .tying import ISOCHOR_OT_tie_lattices, ISOCHOR_OT_untie_lattices

LATTICE = (
    (ISOCHOR_OT_add, "MOD_LATTICE"),
    (ISOCHOR_OT_convert, "FILE_REFRESH"),
    (ISOCHOR_OT_fit_lattice, "FULLSCREEN_EXIT"),
    (ISOCHOR_OT_refine, "MOD_MULTIRES"),
    (ISOCHOR_OT_mirror_lattice, "MOD_MIRROR"),
    (ISOCHOR_OT_tie_lattices, "AUTOMERGE_ON"),
    (ISOCHOR_OT_untie_lattices, "AUTOMERGE_OFF"),
    (ISOCHOR_OT_set_rest, "LINKED"),
    (ISOCHOR_OT_clear_rest, "UNLINKED"),
)
PINS = (
    (ISOCHOR_OT_add_pin, "PINNED"),
    (ISOCHOR_OT_bind_pins, "LINKED"),
    (ISOCHOR_OT_remove_pins, "UNPINNED"),
)
DRIVERS = (
    (ISOCHOR_OT_squash_from_ground, "MESH_PLANE"),
    (ISOCHOR_OT_squash_from_speed, "FORCE_FORCE"),
    (ISOCHOR_OT_twist_from_bone, "BONE_DATA"),
    (ISOCHOR_OT_bend_from_empty, "EMPTY_AXIS"),
)
PHYSICS = (
    (ISOCHOR_OT_simulate, "PHYSICS"),
    (ISOCHOR_OT_free_simulation, "LOOP_BACK"),
)
POINTS = (
    (ISOCHOR_OT_deform_points, "SURFACE_DATA"),
    (ISOCHOR_OT_bake_points, "SHAPEKEY_DATA"),
    (ISOCHOR_OT_restore_points, "LOOP_BACK"),
)
RESULTS = (
    (ISOCHOR_OT_measure_volume, "FCURVE"),
    (ISOCHOR_OT_bake, "FILE_CACHE"),
    (ISOCHOR_OT_free_bake, "LOOP_BACK"),
    (ISOCHOR_OT_apply, "CHECKMARK"),
)
GROUPS = (LATTICE, PINS, DRIVERS, PHYSICS, RESULTS, POINTS, ((ISOCHOR_OT_remove, "X"),))
"""Operator and icon of each line of Object, Volume Lattice, with a line between groups."""


class VIEW3D_MT_isochor(bpy.types.Menu):
    """Everything that can be done with a Volume Lattice"""

    bl_label = "Volume Lattice"

    def draw(self, _context: bpy.types.Context) -> None:
        for number, group in enumerate(GROUPS):
            if number:
                self.layout.separator()
            for operator, icon in group:
                self.layout.operator(operator.bl_idname, icon=icon)
                if operator is ISOCHOR_OT_apply:
                    draw_as_shape_key(self.layout)


def draw_as_shape_key(layout: bpy.types.UILayout) -> None:
    """The other way to apply, as Blender's own menu lists the two."""
    entry = layout.operator(ISOCHOR_OT_apply.bl_idname, text="Apply Volume Lattice as Shape Key", icon="SHAPEKEY_DATA")
    entry.as_shape_key = True


def draw_modifier_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """One line in Add Modifier, Deform."""
    menu.layout.operator(ISOCHOR_OT_add.bl_idname, text="Volume Lattice", icon="MOD_LATTICE")


def draw_object_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """A menu of our own in the Object menu of the 3D View, and in the Lattice menu of a lattice's Edit Mode."""
    menu.layout.separator()
    menu.layout.menu(VIEW3D_MT_isochor.__name__, icon="MOD_LATTICE")


def draw_pin_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """One line in the Vertex and the Face menu of a mesh's Edit Mode."""
    menu.layout.separator()
    menu.layout.operator(ISOCHOR_OT_add_pin.bl_idname, text="Add Volume Lattice Pin", icon="PINNED")


PLACES = (
    ("OBJECT_MT_modifier_add_deform", draw_modifier_entry),
    ("VIEW3D_MT_object", draw_object_entry),
    ("VIEW3D_MT_edit_lattice", draw_object_entry),
    ("VIEW3D_MT_edit_mesh_vertices", draw_pin_entry),
    ("VIEW3D_MT_edit_mesh_faces", draw_pin_entry),
)


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
