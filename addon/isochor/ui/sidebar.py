# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Isochor": what the active object's Volume Lattice did in the frame shown."""

import textwrap

import bpy

import isochor

from ..core import problem
from ..core.report import Report
from ..core.words import Sentence
from ..tool import baked, chain, pin_collection, sockets, stack, state, words
from ..tool.lattices import users_of
from .adding import ISOCHOR_OT_add
from .choosing import active_object
from .fitting import ISOCHOR_OT_fit_lattice
from .mirroring import ISOCHOR_OT_mirror_lattice
from .removing import ISOCHOR_OT_remove

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
        pairs = shown(context)
        if not pairs:
            layout.label(text=nothing_to_show(context))
        for obj, modifier in pairs:
            draw_modifier(layout.box(), obj, modifier, title(context, obj, modifier), line_width(context))
        row = layout.row(align=True)
        row.operator(ISOCHOR_OT_add.bl_idname, text="Add", icon="MOD_LATTICE")
        row.operator(ISOCHOR_OT_remove.bl_idname, text="Remove", icon="X")
        row = layout.row(align=True)
        row.operator(ISOCHOR_OT_fit_lattice.bl_idname, text="Fit Again", icon="FULLSCREEN_EXIT")
        row.operator(ISOCHOR_OT_mirror_lattice.bl_idname, text="Mirror", icon="MOD_MIRROR")


def shown(context: bpy.types.Context) -> list[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """The Volume Lattices of the active mesh, or those that the active lattice shapes, or the active pin belongs to."""
    obj = active_object(context)
    if obj is None:
        return []
    if obj.type == "LATTICE":
        return users_of(obj)
    return [(obj, modifier) for modifier in stack.ours(obj)] or pin_collection.users(obj)


def nothing_to_show(context: bpy.types.Context) -> str:
    """Why there is nothing, in words."""
    obj = active_object(context)
    is_lattice = obj is not None and obj.type == "LATTICE"
    return words.shown("No mesh uses this lattice" if is_lattice else "The active object has none")


def title(context: bpy.types.Context, obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    """The modifier's name, with its object's where that is not the active one."""
    return modifier.name if obj == active_object(context) else f"{obj.name}: {modifier.name}"


def line_width(context: bpy.types.Context) -> int:
    """Letters that fit one line of a box in the sidebar as wide as it is now."""
    pixels = context.region.width / context.preferences.system.ui_scale
    return max(12, int((pixels - ICON_AND_MARGINS) / LETTER_WIDTH))


def draw_modifier(
    layout: bpy.types.UILayout, obj: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str, width: int
) -> None:
    """One modifier's problems and numbers under its name, text in lines of ``width`` letters."""
    layout.label(text=name, icon="MOD_LATTICE", translate=False)
    for text in notes(obj, modifier):
        draw_text(layout, text, "INFO", width)
    memory = state.recall(obj, modifier)
    if memory is None:
        layout.label(text="Baked: not computed" if baked.is_playing(obj) else "Not computed yet")
        return
    for text in memory.report.problems:
        draw_text(layout, text, "ERROR", width)
    for text in memory.report.notes:
        draw_text(layout, text, "INFO", width)
    drawn = "" if is_playing() else memory.cuts.note(memory.report, memory.faces)
    if drawn:
        draw_text(layout, drawn, "INFO", width)
    folds = memory.folding.of(memory.report, compute=not is_playing())
    folded = fold_note(folds)
    if folded:
        draw_text(layout, folded, "INFO", width)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name, value in [*rows(memory.report), *fold_rows(memory.report, folds)]:
        grid.label(text=name, translate=False)
        grid.label(text=value, translate=False)


def is_playing() -> bool:
    """Whether the animation plays in this window, so that the panel must not slow it down."""
    screen = bpy.context.screen
    return screen is not None and bool(screen.is_animation_playing)


def notes(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[str]:
    """What is not wrong, and yet perhaps not what the animator believes."""
    frozen = [problem.in_edit_mode_of_mesh()] if obj.type == "MESH" and obj.mode == "EDIT" else []
    lattice = sockets.read(modifier, sockets.LATTICE)
    deleted = lattice is not None and lattice.library is None and not lattice.users_collection
    memory = state.recall(obj, modifier)
    report = None if memory is None else memory.report
    is_open = report is not None and report.has_surface and bool(report.problems) and not report.keeps_volume
    not_joined = [problem.NOT_WELDED] if is_open and obj.type in ("CURVE", "FONT") else []
    alone = [problem.in_no_scene(lattice.name)] if deleted else []
    return [*frozen, *not_joined, *alone, *notes_on_chain(obj, modifier)]


def notes_on_chain(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[str]:
    """Who else in the row of Volume Lattices that this one stands in corrects, where that is not the last alone."""
    row = [found for found in chain.whole(obj, modifier) if found.show_viewport]
    correcting = [found for found in row if sockets.read(found, "Preserve") > 0.0]
    if modifier not in row or not correcting:
        return []
    if modifier in correcting and modifier != correcting[-1]:
        return [problem.corrected_again(correcting[-1].name)]
    return [problem.last_leaves(modifier.name)] if modifier == row[-1] and modifier != correcting[-1] else []


def draw_text(layout: bpy.types.UILayout, text: str, icon: str, width: int) -> None:
    """Text over as many lines as it needs."""
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(words.shown(text), width)):
        column.label(text=line, translate=False, icon=icon if number == 0 else "BLANK1")


def rows(report: Report) -> list[tuple[str, str]]:
    """Name and value of each number that is known."""
    found: list[tuple[str, str]] = []
    volumes = report.volumes
    if volumes is not None:
        if volumes.bodies > 1:
            found.append((words.shown("Volumes kept"), f"{volumes.bodies}"))
        found += [
            (words.shown("Target volume"), f"{volumes.target:.6g}"),
            (words.shown("Lattice alone"), f"{volumes.before:.6g} ({percent(volumes.before, volumes.target)})"),
            (words.shown("Corrected"), f"{volumes.after:.6g}"),
            (words.shown("Error" if volumes.bodies == 1 else "Largest error"), f"{volumes.error:.1e}"),
        ]
    if report.missing:
        found.append((words.shown("Missing volume"), f"{report.missing:.4g}"))
    if report.largest_displacement is not None:
        found.append((words.shown("Points moved up to"), f"{report.largest_displacement:.4g}"))
    if report.vertices_outside is not None:
        found.append((words.shown("Vertices outside"), f"{report.vertices_outside}"))
    if report.result is not None:
        found.append((words.shown("Computed on"), report.device_name))
    found.append((words.shown("Time"), f"{report.milliseconds:.1f} ms"))
    return found


def fold_rows(report: Report, folds: isochor.Folds | None) -> list[tuple[str, str]]:
    """Whether the lattice folds over, as a name and a value; a dash where it is not known."""
    if report.control is None:
        return []
    value = "–"
    if folds is not None:
        found = {
            "unfolded": words.shown("None, proved"),
            "folded": words.shown(Sentence("{count} places", count=len(folds.points))),
            "undecided": words.shown("Undecided"),
        }
        value = found[folds.verdict]
    return [(words.shown("Folds"), value)]


def fold_note(folds: isochor.Folds | None) -> str:
    """What folds mean, in plain words; nothing where there are none."""
    if folds is None or folds.verdict == "unfolded":
        return ""
    return problem.FOLDED if folds else problem.PERHAPS_FOLDED


def percent(volume: float, target: float) -> str:
    """Gain or loss against the target, signed."""
    if not target:
        return "–"
    change = round((volume / target - 1.0) * 100.0, 1)
    return f"{change:+.1f} %" if change else "0 %"


def register() -> None:
    """Adds the tab."""
    bpy.utils.register_class(VIEW3D_PT_isochor)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor)
