# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a lattice as the file holds them: plainly, or one set for each shape key. In Edit Mode the active set
is the one that is edited."""

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import animated

Points = NDArray[np.float32]
PLAIN = ""
"""Name of the set of a lattice without shape keys."""
Sets = dict[str, Points]


def sets(lattice: bpy.types.Object) -> Sets:
    """(N, 3) of each set, in lattice space, u fastest."""
    return {name: _read(*holder) for name, holder in _holders(lattice).items()}


def write(lattice: bpy.types.Object, changed: Sets) -> bool:
    """Sets these; those that another file owns, and locked shape keys, stay as they are. Whether anything was set."""
    data = lattice.data
    if not changed or not data.is_editable or data.override_library is not None:
        return False
    keys = data.shape_keys
    holders = _holders(lattice)
    for name, points in changed.items():
        if keys is not None and keys.key_blocks[name].lock_shape:
            continue
        holder, place = holders[name]
        flat = np.ascontiguousarray(points, np.float32).reshape(-1)
        holder.foreach_set(place, flat)
        if keys is not None and name == keys.reference_key.name and not data.is_editmode:
            # Blender keeps the points themselves like their first shape key.
            data.points.foreach_set("co_deform", flat)
    data.update_tag()
    return True


def mixed(lattice: bpy.types.Object, found: Sets) -> NDArray[np.float64]:
    """(N, 3) what relative shape keys make of the sets at their present values, without modifiers."""
    keys = lattice.data.shape_keys
    if keys is None:
        return found[PLAIN].astype(np.float64)
    total = found[keys.reference_key.name].astype(np.float64)
    for block in keys.key_blocks:
        if keys.use_relative and not block.mute and block != keys.reference_key:
            total += block.value * (found[block.name].astype(np.float64) - found[block.relative_key.name])
    return total


def values(lattice: bpy.types.Object) -> dict[str, float]:
    """By which value each shape key counts, where nothing animates them."""
    keys = lattice.data.shape_keys
    if keys is None or animated.paths(keys):
        return {}
    return {block.name: 0.0 if block.mute else round(block.value, 6) for block in keys.key_blocks}


def is_modified(lattice: bpy.types.Object) -> bool:
    """Whether hooks or other modifiers move the points in the viewport."""
    return any(modifier.show_viewport for modifier in lattice.modifiers)


def _holders(lattice: bpy.types.Object) -> dict[str, tuple[Any, str]]:
    data = lattice.data
    if data.shape_keys is None:
        return {PLAIN: (data.points, "co_deform")}
    found: dict[str, tuple[Any, str]] = {block.name: (block.data, "co") for block in data.shape_keys.key_blocks}
    if data.is_editmode and lattice.active_shape_key is not None:
        found[lattice.active_shape_key.name] = (data.points, "co_deform")
    return found


def _read(holder: Any, name: str) -> Points:
    values: Points = np.empty(len(holder) * 3, np.float32)
    holder.foreach_get(name, values)
    return values.reshape(-1, 3)
