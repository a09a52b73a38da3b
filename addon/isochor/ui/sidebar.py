# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Isochor": what the active object's Volume Lattice did in the frame shown."""

import textwrap

import bpy

from ..core.report import Report
from ..tool import baked, stack, state
from .adding import ISOCHOR_OT_add
from .removing import ISOCHOR_OT_remove

INSIDE_OUT = "The mesh is inside out: its volume counts as negative, and is kept all the same."
LETTER_WIDTH, ICON_AND_MARGINS = 7.0, 75.0
"""Pixels, at interface scale 1, of a letter of average width, and of what stands beside a line of text in a box."""


class VIEW3D_PT_isochor(bpy.types.Panel):
    """Numbers and problems of the active object"""

    bl_label = "Volume Lattice"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = context.object
        modifiers = stack.ours(obj) if obj is not None and obj.type == "MESH" else []
        if not modifiers:
            layout.label(text="The active object has none")
        for modifier in modifiers:
            draw_modifier(layout.box(), obj, modifier, line_width(context))
        row = layout.row(align=True)
        row.operator(ISOCHOR_OT_add.bl_idname, text="Add", icon="MOD_LATTICE")
        row.operator(ISOCHOR_OT_remove.bl_idname, text="Remove", icon="X")


def line_width(context: bpy.types.Context) -> int:
    """Letters that fit one line of a box in the sidebar as wide as it is now."""
    pixels = context.region.width / context.preferences.system.ui_scale
    return max(12, int((pixels - ICON_AND_MARGINS) / LETTER_WIDTH))


def draw_modifier(
    layout: bpy.types.UILayout, obj: bpy.types.Object, modifier: bpy.types.NodesModifier, width: int
) -> None:
    """One modifier's problems and numbers, text in lines of ``width`` letters."""
    layout.label(text=modifier.name, icon="MOD_LATTICE")
    memory = state.recall(obj, modifier)
    if memory is None:
        layout.label(text="Baked: not computed" if baked.KEY in obj else "Not computed yet")
        return
    for text in memory.report.problems:
        draw_text(layout, text, "ERROR", width)
    if memory.report.inside_out:
        draw_text(layout, INSIDE_OUT, "INFO", width)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name, value in rows(memory.report):
        grid.label(text=name)
        grid.label(text=value)


def draw_text(layout: bpy.types.UILayout, text: str, icon: str, width: int) -> None:
    """Text over as many lines as it needs."""
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def rows(report: Report) -> list[tuple[str, str]]:
    """Name and value of each number that is known."""
    found: list[tuple[str, str]] = []
    volumes = report.volumes
    if volumes is not None:
        found += [
            ("Target volume", f"{volumes.target:.6g}"),
            ("Lattice alone", f"{volumes.before:.6g} ({percent(volumes.before, volumes.target)})"),
            ("Corrected", f"{volumes.after:.6g}"),
            ("Error", f"{volumes.error:.1e}"),
            ("Points moved up to", f"{report.largest_displacement:.4g}"),
        ]
    if report.vertices_outside is not None:
        found.append(("Vertices outside", f"{report.vertices_outside}"))
    if report.result is not None:
        found.append(("Computed on", report.device_name))
    found.append(("Time", f"{report.milliseconds:.1f} ms"))
    return found


def percent(volume: float, target: float) -> str:
    """Gain or loss against the target, signed."""
    return f"{(volume / target - 1.0) * 100.0:+.1f} %" if target else "–"


def register() -> None:
    """Adds the tab."""
    bpy.utils.register_class(VIEW3D_PT_isochor)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor)
