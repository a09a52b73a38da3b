# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Bake of the sidebar tab "Isochor": what plays now, and the ways to change that."""

import bpy

from ..core.words import Sentence
from ..tool import baked, words
from .baking import ISOCHOR_OT_bake, ISOCHOR_OT_free_bake
from .choosing import active_object


class VIEW3D_PT_isochor_bake(bpy.types.Panel):
    """Recording the deformed mesh, so that it plays without this add-on"""

    bl_label = "Bake"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "VIEW3D_PT_isochor"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 13

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = active_object(context)
        if obj is not None and baked.is_playing(obj):
            draw_playing(layout, baked.stand_in(obj))
        row = layout.row(align=True)
        row.operator(ISOCHOR_OT_bake.bl_idname, text="Bake", icon="FILE_CACHE")
        row.operator(ISOCHOR_OT_free_bake.bl_idname, text="Free", icon="LOOP_BACK")


def draw_playing(layout: bpy.types.UILayout, stand_in: bpy.types.Modifier | None) -> None:
    """What plays instead of the Volume Lattice."""
    if stand_in is None:
        layout.label(text="Baked", icon="CHECKMARK")
        return
    text = Sentence(
        "“{name}” plays" if stand_in.show_viewport else "“{name}” plays in renders alone", name=stand_in.name
    )
    layout.label(text=words.shown(text), translate=False, icon="CHECKMARK")
    if stand_in.type == "MESH_CACHE":
        layout.prop(stand_in, "filepath", text="")


def register() -> None:
    """Adds the panel."""
    bpy.utils.register_class(VIEW3D_PT_isochor_bake)


def unregister() -> None:
    """Takes it out."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor_bake)
