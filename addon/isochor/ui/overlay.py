# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay's settings, in the sidebar and in the 3D View's Overlays popover."""

import bpy

from ..tool import overlay, overlay_settings


class VIEW3D_PT_isochor_overlay(bpy.types.Panel):
    """What the correction makes of the lattice, drawn in the view"""

    bl_label = "Overlay"
    bl_parent_id = "VIEW3D_PT_isochor"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 20

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(overlay_settings.of(context.workspace), "show", text="")

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if not context.space_data.overlay.show_overlays:
            layout.label(text="The view's overlays are off", icon="INFO")
        settings = overlay_settings.of(context.workspace)
        layout.active = settings.show and context.space_data.overlay.show_overlays
        column = layout.column(heading="Show")
        column.prop(settings, "show_lattice")
        column.prop(settings, "show_points")
        column.prop(settings, "show_isolines")
        column.prop(settings, "show_folds")
        _draw_isolines(layout, settings)
        _draw_look(layout, settings)


def _draw_isolines(layout: bpy.types.UILayout, settings: overlay_settings.IsochorOverlay) -> None:
    column = layout.column()
    column.active = settings.show_isolines
    column.prop(settings, "divisions")
    column.prop(settings, "samples")
    column.prop(settings, "inside")


def _draw_look(layout: bpy.types.UILayout, settings: overlay_settings.IsochorOverlay) -> None:
    column = layout.column()
    column.prop(settings, "only_selected")
    column.prop(settings, "in_front")
    column = layout.column(align=True)
    column.prop(settings, "lattice_colour")
    column.prop(settings, "space_colour")
    column = layout.column(align=True)
    column.prop(settings, "line_width")
    column.prop(settings, "point_size")
    column = layout.column()
    column.active = settings.show_points
    column.prop(settings, "colour_range")
    column.prop(settings, "show_legend")


class VIEW3D_PT_isochor_overlay_popover(bpy.types.Panel):
    """What the correction makes of the lattice, drawn in the view"""

    bl_label = "Volume Lattice"
    bl_parent_id = "VIEW3D_PT_overlay"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(overlay_settings.of(context.workspace), "show", text="")

    def draw(self, context: bpy.types.Context) -> None:
        settings = overlay_settings.of(context.workspace)
        split = self.layout.split()
        split.active = settings.show and context.space_data.overlay.show_overlays
        left, right = split.column(align=True), split.column(align=True)
        left.prop(settings, "show_lattice")
        left.prop(settings, "show_points")
        right.prop(settings, "show_isolines")
        right.prop(settings, "show_folds")
        right.prop(settings, "in_front")


PANELS = (VIEW3D_PT_isochor_overlay, VIEW3D_PT_isochor_overlay_popover)


def register() -> None:
    """Adds the drawing and its panels."""
    overlay.register()
    for panel in PANELS:
        bpy.utils.register_class(panel)


def unregister() -> None:
    """Takes them away."""
    for panel in reversed(PANELS):
        bpy.utils.unregister_class(panel)
    overlay.unregister()
