# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading and writing the points of a lattice object as the animator edits them: in Edit Mode, on the active shape
key, or plainly."""

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem

Points = NDArray[np.float32]


def shape(lattice: bpy.types.Object) -> tuple[int, int, int]:
    """Points along u, v, w."""
    return lattice.data.points_u, lattice.data.points_v, lattice.data.points_w


def read(lattice: bpy.types.Object) -> Points:
    """(N, 3) points in lattice space, u fastest."""
    holder, name = _edited(lattice)
    return _read(holder, name, 3, np.float32).reshape(-1, 3)


def read_own(lattice: bpy.types.Object) -> Points:
    """(N, 3) the data's own points, whatever shape key is active; not in Edit Mode."""
    return _read(lattice.data.points, "co_deform", 3, np.float32).reshape(-1, 3)


def resize(lattice: bpy.types.Object, points: NDArray[np.floating[Any]], shape: tuple[int, int, int]) -> None:
    """Gives the lattice another number of points, u fastest; not in Edit Mode, nor where it has shape keys."""
    data = lattice.data
    data.points_u, data.points_v, data.points_w = shape
    data.points.foreach_set("co_deform", np.ascontiguousarray(points, np.float32).reshape(-1))
    data.update_tag()


def write(lattice: bpy.types.Object, points: Points) -> None:
    """Sets them. Raises ``Problem`` where they belong to another file or the active shape key is locked."""
    refuse_if_locked(lattice)
    holder, name = _edited(lattice)
    flat = np.ascontiguousarray(points, np.float32).reshape(-1)
    holder.foreach_set(name, flat)
    key = _active_key(lattice)
    if key is not None and key == lattice.data.shape_keys.reference_key:
        # Blender keeps the points themselves like their first shape key.
        lattice.data.points.foreach_set("co_deform", flat)
    lattice.data.update_tag()


def refuse_if_locked(lattice: bpy.types.Object) -> None:
    """Raises ``Problem`` where the points must not be changed."""
    if not lattice.data.is_editable or lattice.data.override_library is not None:
        raise problem.Problem(problem.foreign_points(lattice.name))
    key = lattice.active_shape_key
    if key is not None and key.lock_shape:
        raise problem.Problem(problem.locked_shape_key(lattice.name, key.name))


def selected(lattice: bpy.types.Object) -> NDArray[np.bool_]:
    """(N,) which points are selected in Edit Mode."""
    return _read(lattice.data.points, "select", 1, np.bool_)


def _edited(lattice: bpy.types.Object) -> tuple[Any, str]:
    """What holds the points that are edited, and the name of their place in it."""
    key = _active_key(lattice)
    return (lattice.data.points, "co_deform") if key is None else (key.data, "co")


def _active_key(lattice: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """None in Edit Mode too: there the points are those of the active shape key, until the mode is left."""
    return None if lattice.data.is_editmode else lattice.active_shape_key


def _read(holder: Any, name: str, width: int, dtype: type[np.generic]) -> NDArray[Any]:
    values: NDArray[Any] = np.empty(len(holder) * width, dtype)
    holder.foreach_get(name, values)
    return values
