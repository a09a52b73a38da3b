# SPDX-License-Identifier: GPL-3.0-or-later
"""Picking a point of a surface with the mouse in a 3D View."""

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector
from numpy.typing import NDArray

from ..tool import words

BREAKS_OFF = ("ESC", "RIGHTMOUSE")
NAVIGATES = (
    "MIDDLEMOUSE",
    "MOUSEMOVE",
    "WHEELUPMOUSE",
    "WHEELDOWNMOUSE",
    "TRACKPADPAN",
    "TRACKPADZOOM",
    "MOUSEROTATE",
    "NDOF_MOTION",
)
"""Events that turn and move the view meanwhile, with those of the number pad."""
HINT = "Click on the surface: a pin holds it there. Esc or right click: none"


def start(context: bpy.types.Context) -> None:
    """Shows that a click is awaited."""
    context.window.cursor_modal_set("CROSSHAIR")
    context.workspace.status_text_set(words.shown(HINT))


def end(context: bpy.types.Context) -> None:
    """Takes that back."""
    context.window.cursor_modal_restore()
    context.workspace.status_text_set(None)


def navigates(event: bpy.types.Event) -> bool:
    """Whether the event is one for the view; with Alt the left button can stand for the middle one."""
    return event.type in NAVIGATES or event.type.startswith("NUMPAD") or (event.type == "LEFTMOUSE" and event.alt)


def under_cursor(
    context: bpy.types.Context, event: bpy.types.Event, objects: list[bpy.types.Object]
) -> NDArray[np.float64] | None:
    """Where the line of sight through the mouse first meets one of the objects as shown, in the world; None where it
    does not, or the mouse is in no 3D View."""
    for area in context.window.screen.areas:
        for region in area.regions if area.type == "VIEW_3D" else ():
            x, y = event.mouse_x - region.x, event.mouse_y - region.y
            if region.type == "WINDOW" and 0 <= x < region.width and 0 <= y < region.height:
                place = Vector((x, y))
                origin = view3d_utils.region_2d_to_origin_3d(region, region.data, place)
                direction = view3d_utils.region_2d_to_vector_3d(region, region.data, place)
                return first_hit(objects, origin, direction, context.evaluated_depsgraph_get())
    return None


def first_hit(
    objects: list[bpy.types.Object], origin: Vector, direction: Vector, depsgraph: bpy.types.Depsgraph
) -> NDArray[np.float64] | None:
    """Where a ray in the world first meets what is shown of the objects."""
    found = []
    for obj in objects:
        shown = obj.evaluated_get(depsgraph)
        to_object = shown.matrix_world.inverted_safe()
        start = to_object @ origin
        hit, point, _normal, _face = shown.ray_cast(start, to_object @ (origin + direction) - start)
        if hit:
            world = shown.matrix_world @ point
            found.append(((world - origin).length, np.array(world, np.float64)))
    return min(found, key=lambda one: one[0])[1] if found else None
