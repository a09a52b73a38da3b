# SPDX-License-Identifier: GPL-3.0-or-later
"""The part "Pins" of the sidebar tab: what holds the surface, and how exactly."""

import bpy

from ..core.words import Sentence, named
from ..tool import pins, sockets, state
from .pinning import ISOCHOR_OT_add_pin, ISOCHOR_OT_bind_pins, ISOCHOR_OT_remove_pins, pinned_modifiers
from .sidebar import VIEW3D_PT_isochor, draw_text, line_width


class VIEW3D_PT_isochor_pins(bpy.types.Panel):
    """Empties that hold points of the surface"""

    bl_label = "Pins"
    bl_parent_id = VIEW3D_PT_isochor.__name__
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        for obj, modifier in pinned_modifiers(context):
            draw_text(column, named(obj.name, state_of(obj, modifier)), "PINNED", line_width(context))
            if sockets.PINS in sockets.identifiers(modifier.node_group):
                draw_inputs(column, modifier)
        self.layout.operator(ISOCHOR_OT_add_pin.bl_idname, icon="PINNED")
        row = self.layout.row(align=True)
        row.operator(ISOCHOR_OT_bind_pins.bl_idname, icon="LINKED")
        row.operator(ISOCHOR_OT_remove_pins.bl_idname, icon="UNPINNED")


def draw_inputs(layout: bpy.types.UILayout, modifier: bpy.types.NodesModifier) -> None:
    """The modifier's two inputs, as its own panel shows them."""
    owner, path = sockets.property_of(modifier, sockets.PINS)
    if hasattr(modifier, "properties"):
        layout.prop(owner, path, text=sockets.PINS)
    else:
        layout.prop_search(owner, path, bpy.data, "collections", text=sockets.PINS)
    owner, path = sockets.property_of(modifier, sockets.FALLOFF)
    layout.prop(owner, path, text=sockets.FALLOFF)


def state_of(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    """How many pins hold, and how exactly, in plain words."""
    memory = state.recall(obj, modifier)
    report = None if memory is None else memory.report
    if report is None or report.pins is None:
        return Sentence("no pins") if not pins.objects(modifier) else Sentence("no pin holds")
    if report.largest_miss is None:
        return Sentence("no pin holds")
    count, miss = len(report.pins), f"{report.largest_miss:.0e}"
    if count == 1:
        return Sentence("1 pin, which misses by {miss} m", miss=miss)
    return Sentence("{count} pins, largest miss {miss} m", count=count, miss=miss)


def register() -> None:
    """Adds the panel."""
    bpy.utils.register_class(VIEW3D_PT_isochor_pins)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor_pins)
