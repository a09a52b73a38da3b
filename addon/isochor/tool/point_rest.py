# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformed or baked control points live on a copy of an object's data, which names the data at rest, and the way back.

The data at rest (points, weights, handles, shape keys, their animation) stays in the file untouched.
"""

import hashlib

import bpy
import numpy as np

from . import animated, control_points
from .control_points import Array

REST, WRITTEN = "isochor_rest_points", "isochor_written_points"
"""Custom properties of the copy: the data at rest, and a fingerprint of the points that were written."""
POINT_PATHS = ("points[", "splines[")
"""How data paths of single points begin: their curves would overwrite what is written."""


def is_deformed(obj: bpy.types.Object) -> bool:
    """Whether the object shows deformed or baked points."""
    return obj.data is not None and isinstance(obj.data.get(REST), bpy.types.ID)


def rest_of(obj: bpy.types.Object) -> bpy.types.ID:
    """The data at rest; the object's own where its points were never deformed."""
    return obj.data[REST] if is_deformed(obj) else obj.data


def is_edited(obj: bpy.types.Object) -> bool:
    """Whether somebody has moved deformed points since they were written."""
    known = obj.data.get(WRITTEN, "") if is_deformed(obj) else ""
    return bool(known) and known != _fingerprint(control_points.read(obj.data))


def shape_now(obj: bpy.types.Object) -> Array:
    """(P, 3) control points of the object's present data as its shape keys mix them in this frame."""
    if obj.data.shape_keys is None:
        return control_points.read(obj.data)
    index = obj.active_shape_key_index
    key = obj.shape_key_add(name="Mixed", from_mix=True)
    points = control_points.read_key(obj.data, key)
    obj.shape_key_remove(key)
    obj.active_shape_key_index = index
    return points


def show(obj: bpy.types.Object, points: Array) -> None:
    """Has the object show these points, as float32, in place of those at rest."""
    _onto_copy(obj, "Deformed")
    control_points.write(obj.data, points)
    obj.data[WRITTEN] = _fingerprint(control_points.read(obj.data))


def prepare_for_keys(obj: bpy.types.Object) -> None:
    """Has the object show a copy of its data at rest that has no shape keys, to which they can be added."""
    _onto_copy(obj, "Baked")


def restore(obj: bpy.types.Object) -> bpy.types.ID | None:
    """Has the object show its points at rest again; the deformed data, which the caller keeps or removes."""
    if not is_deformed(obj):
        return None
    shown = obj.data
    obj.data = shown[REST]
    return shown


def put_back(obj: bpy.types.Object, shown: bpy.types.ID | None) -> None:
    """Takes back what ``restore`` did."""
    if shown is not None:
        obj.data = shown


def take_as_rest(obj: bpy.types.Object) -> None:
    """Makes the points that the object shows its points at rest."""
    for name in (REST, WRITTEN):
        if name in obj.data:
            del obj.data[name]


def remove(shown: bpy.types.ID | None) -> None:
    """Removes deformed data that nothing uses any more."""
    if shown is None or shown.users:
        return
    animation = shown.shape_keys.animation_data if shown.shape_keys is not None else None
    action = None if animation is None else animation.action
    if animation is not None:
        shown.shape_keys.animation_data_clear()
    holder = bpy.data.lattices if isinstance(shown, bpy.types.Lattice) else bpy.data.curves
    holder.remove(shown)
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)


def _onto_copy(obj: bpy.types.Object, what: str) -> None:
    """Gives the object a copy of its data, which is that at rest, without keys and without curves of single points."""
    rest = obj.data
    data = rest.copy()
    data.name = f"{rest.name} {what}"
    obj.data = data
    if data.shape_keys is not None:
        # Before Blender 5 clearing keys alone leaves their action counted as used.
        data.shape_keys.animation_data_clear()
        obj.shape_key_clear()
    if any(path.startswith(POINT_PATHS) for path in animated.paths(data)):
        data.animation_data_clear()
    control_points.free_handles(data)
    data[REST] = rest


def _fingerprint(points: Array) -> str:
    return hashlib.sha256(np.ascontiguousarray(points, np.float32).tobytes()).hexdigest()
