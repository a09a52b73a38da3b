# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of any object that the modifier deforms: its own, and as Blender shows them."""

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

BEZIER = 2
"""What the attribute curve_type holds for Bézier curves."""
HANDLES = ("handle_left", "handle_right")
"""Attributes of Bézier curves that are positions too."""


def pieces(obj_evaluated: bpy.types.Object) -> tuple[Any, list[bpy.types.ID]]:
    """All geometry with points of an evaluated object: vertices, curves, points; and what holds them, which must be
    kept as long as they are used."""
    geometry = obj_evaluated.evaluated_geometry()
    mesh = obj_evaluated.data if obj_evaluated.type == "MESH" else geometry.mesh
    found = (mesh, geometry.curves, geometry.pointcloud)
    return geometry, [data for data in found if data is not None]


def shown(obj_evaluated: bpy.types.Object) -> NDArray[np.float64]:
    """(V, 3) positions of all points of an evaluated object, handles of Bézier curves among them, in its own space."""
    holder, found = pieces(obj_evaluated)
    parts = [part for data in found for part in (vectors(data, "position"), *_handles(data))]
    del holder
    return np.concatenate([np.empty((0, 3), np.float32), *parts]).astype(np.float64)


def own(obj: bpy.types.Object) -> NDArray[np.float64]:
    """(V, 3) positions of the points of the object's own data, before any modifier; none of a text."""
    if obj.type in ("CURVE", "FONT"):
        places = [place for spline in obj.data.splines for place in _places(spline)] if obj.type == "CURVE" else []
        return np.array([tuple(place)[:3] for place in places], np.float64).reshape(-1, 3)
    return vectors(obj.data, "position").astype(np.float64)


def vectors(data: bpy.types.ID, name: str) -> NDArray[np.float32]:
    """(V, 3) of an attribute that holds a vector a point."""
    values = data.attributes[name].data
    flat = np.empty(len(values) * 3, np.float32)
    if len(flat):
        values.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def count(obj: bpy.types.Object) -> int:
    """Points of the object's own data before any modifier, of a text its letters; tells of another shape."""
    if obj.type == "MESH":
        return len(obj.data.vertices)
    if obj.type == "FONT":
        return len(obj.data.body)
    if obj.type == "CURVE":
        return sum(len(spline.bezier_points) + len(spline.points) for spline in obj.data.splines)
    return len(obj.data.points)


def selected(obj: bpy.types.Object) -> NDArray[np.float64]:
    """(V, 3) selected control points of a curve in Edit Mode, with the handles of those that have some; of anything
    else, or where nothing is selected, none."""
    splines = obj.data.splines if obj.type == "CURVE" else ()
    chosen = [place for spline in splines for place in _places(spline, only_selected=True)]
    return np.array([tuple(place)[:3] for place in chosen], np.float64).reshape(-1, 3)


def _places(spline: bpy.types.Spline, only_selected: bool = False) -> Iterator[Any]:
    """Of control points, each between its handles where it has some."""
    for point in spline.bezier_points:
        if point.select_control_point or not only_selected:
            yield from (point.handle_left, point.co, point.handle_right)
    yield from (point.co for point in spline.points if point.select or not only_selected)


def _handles(data: bpy.types.ID) -> list[NDArray[np.float32]]:
    """Positions of the handles of Bézier curves: of other curves among such Blender keeps nothing of meaning there."""
    kinds = data.attributes.get("curve_type") if isinstance(data, bpy.types.Curves) else None
    if kinds is None:
        return []
    is_bezier = np.array([kind.value == BEZIER for kind in kinds.data])
    begins = np.empty(len(is_bezier) + 1, np.int32)
    data.curve_offset_data.foreach_get("value", begins)
    chosen = np.repeat(is_bezier, np.diff(begins))
    return [vectors(data, name)[chosen] for name in HANDLES if name in data.attributes]
