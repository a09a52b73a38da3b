# SPDX-License-Identifier: GPL-3.0-or-later
"""Control points of surfaces, curves and lattices: read, written, and written into shape keys.

The points of a lattice, u fastest; of a surface or curve those of its splines, one after the other, and of a Bézier
spline its points, then all its left handles, then all its right ones.
"""

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.nurbs import Direction
from ..core.shell import Patch

Array = NDArray[np.float64]
KINDS = ("SURFACE", "LATTICE", "CURVE")
"""Types of objects that have such points."""
PLACES = ("co", "handle_left", "handle_right")
"""What of a Bézier point moves."""


def read(data: bpy.types.ID) -> Array:
    """(P, 3) in the object's own space."""
    if isinstance(data, bpy.types.Lattice):
        return _vectors(data.points, "co_deform", 3)
    parts = [part for spline in data.splines for part in _of_spline(spline)]
    return np.concatenate([np.empty((0, 3)), *parts])


def write(data: bpy.types.ID, points: Array) -> None:
    """Sets them; weights and the like stay. Handles become free, so that Blender does not work them out anew."""
    if isinstance(data, bpy.types.Lattice):
        _set(data.points, "co_deform", points)
    else:
        first = 0
        for spline in data.splines:
            first = _write_spline(spline, points, first)
    data.update_tag()


def read_key(data: bpy.types.ID, key: bpy.types.ShapeKey) -> Array:
    """The same of a shape key of the data."""
    places = _vectors(key.data, "co", 3)
    if isinstance(data, bpy.types.Lattice):
        return places
    parts, first = [np.empty((0, 3))], 0
    for spline in data.splines:
        count = _count(spline)
        parts.append(places[first : first + count])
        if spline.type == "BEZIER":
            for name in PLACES[1:]:
                parts.append(np.array([getattr(key.data[first + i], name) for i in range(count)], np.float64))
        first += count
    return np.concatenate(parts)


def write_key(data: bpy.types.ID, key: bpy.types.ShapeKey, points: Array) -> None:
    """Sets a shape key of the data."""
    if isinstance(data, bpy.types.Lattice):
        _set(key.data, "co", points)
        return
    places, point, first = [], 0, 0
    for spline in data.splines:
        count = _count(spline)
        places.append(points[first : first + count])
        if spline.type == "BEZIER":
            for number, name in enumerate(PLACES[1:], 1):
                for index in range(count):
                    setattr(key.data[point + index], name, points[first + number * count + index])
            first += 2 * count
        point, first = point + count, first + count
    _set(key.data, "co", np.concatenate(places))


def free_handles(data: bpy.types.ID) -> None:
    """Has every Bézier handle stay where it is put."""
    for spline in () if isinstance(data, bpy.types.Lattice) else data.splines:
        for point in spline.bezier_points:
            point.handle_left_type = point.handle_right_type = "FREE"


def patches(data: bpy.types.ID) -> list[Patch]:
    """The splines of a surface object, as the viewport draws them."""
    found, first = [], 0
    for spline in data.splines:
        found.append(Patch(first, _direction(spline, "u"), _direction(spline, "v"), _weights(spline)))
        first += len(spline.points)
    return found


def _direction(spline: bpy.types.Spline, name: str) -> Direction:
    def get(prefix: str) -> Any:
        return getattr(spline, f"{prefix}_{name}")

    return Direction(
        get("point_count"), get("order"), get("use_cyclic"), get("use_endpoint"), get("use_bezier"), get("resolution")
    )


def _weights(spline: bpy.types.Spline) -> Array:
    flat = np.empty(len(spline.points) * 4, np.float32)
    spline.points.foreach_get("co", flat)
    return flat[3::4].astype(np.float64)


def _count(spline: bpy.types.Spline) -> int:
    return len(spline.bezier_points if spline.type == "BEZIER" else spline.points)


def _of_spline(spline: bpy.types.Spline) -> list[Array]:
    if spline.type == "BEZIER":
        return [_vectors(spline.bezier_points, name, 3) for name in PLACES]
    return [_vectors(spline.points, "co", 4)[:, :3]]


def _write_spline(spline: bpy.types.Spline, points: Array, first: int) -> int:
    """Writes the spline's share from the point ``first`` on; the first of the next spline."""
    count = _count(spline)
    if spline.type != "BEZIER":
        places = np.column_stack([points[first : first + count], _weights(spline)])
        _set(spline.points, "co", places)
        return first + count
    for number, name in enumerate(PLACES):
        begin = first + number * count
        _set(spline.bezier_points, name, points[begin : begin + count])
    return first + len(PLACES) * count


def _vectors(holder: Any, name: str, width: int) -> Array:
    flat = np.empty(len(holder) * width, np.float32)
    holder.foreach_get(name, flat)
    return flat.reshape(-1, width).astype(np.float64)


def _set(holder: Any, name: str, values: Array) -> None:
    holder.foreach_set(name, np.ascontiguousarray(values, np.float32).reshape(-1))
