# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the overlay in 3D Views: corrected lattices, their control points coloured by displacement, deformed space."""

import logging
from collections.abc import Callable, Sequence
from typing import Any

import bpy
import gpu
from bpy.app.handlers import persistent

from . import overlay_batches, overlay_geometry, overlay_legend, overlay_settings
from .overlay_geometry import Fold, Shown

log = logging.getLogger(__name__)
_complaints: set[str] = set()
_handles: list[Any] = []

FOLD_SIZE = 6.0
"""Diameter, in pixels at interface scale 1, of the points that mark a fold: sixteen of them on a side of the lattice
are then a cloud through which the mesh can still be seen."""


def draw_view() -> None:
    """Everything with a place in the scene; a 3D View calls it each time that it draws itself."""
    guarded(_draw_view)


def draw_pixels() -> None:
    """The legend."""
    guarded(_draw_pixels)


def current_context() -> bpy.types.Context:
    """What Blender is drawing."""
    return bpy.context


def guarded(draw: Callable[[bpy.types.Context, overlay_settings.IsochorOverlay], None]) -> None:
    """Draws where the overlay is on. A fault is told once, not at every redraw, and never reaches Blender's drawing."""
    context = current_context()
    try:
        settings = overlay_settings.of(context.workspace)
        if settings.show and context.space_data is not None and context.space_data.overlay.show_overlays:
            draw(context, settings)
    except Exception as fault:
        if str(fault) not in _complaints:
            _complaints.add(str(fault))
            log.exception("The Volume Lattice overlay could not be drawn")


def in_view(context: bpy.types.Context, settings: overlay_settings.IsochorOverlay) -> list[Shown]:
    """What there is to draw in the 3D View of the context."""
    view_layer, space = context.view_layer, context.space_data
    if view_layer.depsgraph is None:
        return []

    def visible(obj: bpy.types.Object) -> bool:
        return obj.visible_get(view_layer=view_layer, viewport=space)

    pairs = overlay_geometry.modifiers_in_view(view_layer, visible, settings.only_selected)
    fold = Fold.LEAVE
    if settings.show_folds:
        # Each frame of an animation has another shape: to look for folds in all of them would slow it down.
        is_playing = context.screen is not None and context.screen.is_animation_playing
        fold = Fold.RECALL if is_playing else Fold.COMPUTE
    return overlay_geometry.shown(pairs, view_layer.depsgraph, settings.wanted(), fold)


def full_colour(settings: overlay_settings.IsochorOverlay, found: list[Shown]) -> float:
    """Displacement in world units that has the last colour."""
    return settings.colour_range or max((one.largest for one in found), default=0.0)


def _draw_view(context: bpy.types.Context, settings: overlay_settings.IsochorOverlay) -> None:
    found = in_view(context, settings)
    scale = full_colour(settings, found)
    before = gpu.state.depth_test_get(), gpu.state.depth_mask_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("NONE" if settings.in_front else "LESS_EQUAL")
    gpu.state.depth_mask_set(False)
    gpu.state.blend_set("ALPHA")
    gpu.state.program_point_size_set(True)
    try:
        for one in found:
            with gpu.matrix.push_pop():
                gpu.matrix.multiply_matrix(one.to_world)
                _draw_one(settings, overlay_batches.batches_of(one, scale), context.preferences.system.ui_scale)
        # Folds lie inside the mesh, which would hide them; and over what else is drawn.
        gpu.state.depth_test_set("NONE")
        for one in found:
            folded = overlay_batches.folds_of(one)
            if folded is not None:
                with gpu.matrix.push_pop():
                    gpu.matrix.multiply_matrix(one.to_world)
                    _draw_points(folded, FOLD_SIZE * context.preferences.system.ui_scale)
    finally:
        gpu.state.depth_test_set(before[0])
        gpu.state.depth_mask_set(before[1])
        gpu.state.blend_set(before[2])
        gpu.state.program_point_size_set(False)
    there = overlay_geometry.keys_of_file()
    overlay_geometry.forget_all_but(there)
    overlay_batches.forget_all_but(there)


def _draw_one(settings: overlay_settings.IsochorOverlay, batches: dict[str, gpu.types.GPUBatch], scale: float) -> None:
    if settings.show_isolines and "isolines" in batches:
        _draw_lines(batches["isolines"], 1.0 * scale, settings.space_colour)
    if settings.show_lattice and "lattice" in batches:
        _draw_lines(batches["lattice"], settings.line_width * scale, settings.lattice_colour)
    if settings.show_points:
        _draw_lines(batches["paths"], settings.line_width * scale, None)
        _draw_points(batches["points"], settings.point_size * scale)


def _draw_points(batch: gpu.types.GPUBatch, size: float) -> None:
    """In the colours that they have."""
    shader = overlay_batches.shader("POINT_FLAT_COLOR")
    shader.bind()
    shader.uniform_float("size", size)
    batch.draw(shader)


def _draw_lines(batch: gpu.types.GPUBatch, width: float, colour: Sequence[float] | None) -> None:
    """One colour, or those of the points where it is None."""
    shader = overlay_batches.shader("POLYLINE_SMOOTH_COLOR" if colour is None else "POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    if colour is not None:
        shader.uniform_float("color", colour)
    batch.draw(shader)


def _draw_pixels(context: bpy.types.Context, settings: overlay_settings.IsochorOverlay) -> None:
    if settings.show_points and settings.show_legend:
        found = in_view(context, settings)
        if found:
            overlay_legend.draw(context, full_colour(settings, found))


def complaints() -> list[str]:
    """What went wrong while drawing since the file was loaded, each once."""
    return sorted(_complaints)


@persistent
def file_loaded(*_arguments: object) -> None:
    """Another file: nothing drawn before belongs to it."""
    clear()


def clear() -> None:
    """Lets go of all that was drawn."""
    overlay_batches.forget_all_but(set())
    _complaints.clear()
    overlay_geometry.forget_all_but(set())


def register() -> None:
    """Has every 3D View draw the overlay."""
    overlay_settings.register()
    for draw, moment in ((draw_view, "POST_VIEW"), (draw_pixels, "POST_PIXEL")):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", moment))
    bpy.app.handlers.load_post.append(file_loaded)


def unregister() -> None:
    """Takes it out again."""
    bpy.app.handlers.load_post.remove(file_loaded)
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    clear()
    overlay_settings.unregister()
