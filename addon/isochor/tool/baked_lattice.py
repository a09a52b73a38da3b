# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of a lattice, one a frame, kept as absolute shape keys on a copy of its data, and the way back.

The animator's own data (points, shape keys, their animation) stays in the file untouched, named by a custom property of
the copy. Modifiers of the lattice object would deform the baked points once more, so they are switched off meanwhile.
"""

import json
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import absolute_keys

BEFORE, MODIFIERS, SETTINGS = "isochor_before", "isochor_modifiers", "isochor_settings"
"""Custom properties of the baked data: the lattice data before, which modifiers were switched off, and with what the
shapes were made."""


def is_baked(lattice: bpy.types.Object) -> bool:
    """Whether the lattice object shows baked shapes."""
    return isinstance(lattice.data.get(BEFORE), bpy.types.Lattice)


def settings_of(lattice: bpy.types.Object) -> dict[str, Any]:
    """With what the baked shapes were made; nothing where there are none."""
    return dict(json.loads(lattice.data.get(SETTINGS, "{}"))) if is_baked(lattice) else {}


def bake(lattice: bpy.types.Object, first: int, shapes: list[NDArray[np.float32]], settings: dict[str, Any]) -> None:
    """Has the lattice object take these shapes (flat, in its own space) in the frames from ``first`` on, linearly
    between, and stay in the first and last beyond. ``settings``: with what they were made, to be kept with them."""
    before = lattice.data
    data = before.copy()
    data.name = f"{before.name} Simulated"
    data.animation_data_clear()
    lattice.data = data
    lattice.shape_key_clear()
    data[BEFORE], data[SETTINGS] = before, json.dumps(settings)
    absolute_keys.add(lattice, first, len(shapes), lambda key, number: key.data.foreach_set("co", shapes[number]))
    _switch_off(lattice)


def free(lattice: bpy.types.Object) -> bpy.types.Lattice:
    """Gives the lattice object its own data back; returns the baked one, which the caller keeps or removes."""
    baked = lattice.data
    lattice.data = baked[BEFORE]
    for name, viewport, render in json.loads(baked[MODIFIERS]):
        if name in lattice.modifiers:
            lattice.modifiers[name].show_viewport, lattice.modifiers[name].show_render = viewport, render
    return baked


def put_back(lattice: bpy.types.Object, baked: bpy.types.Lattice) -> None:
    """Takes back what ``free`` did."""
    lattice.data = baked
    _switch_off(lattice)


def remove(baked: bpy.types.Lattice) -> None:
    """Removes baked data that nothing uses any more."""
    if baked.users:
        return
    animation = baked.shape_keys.animation_data if baked.shape_keys is not None else None
    action = None if animation is None else animation.action
    bpy.data.lattices.remove(baked)
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)


def _switch_off(lattice: bpy.types.Object) -> None:
    lattice.data[MODIFIERS] = json.dumps([[m.name, m.show_viewport, m.show_render] for m in lattice.modifiers])
    for modifier in lattice.modifiers:
        modifier.show_viewport = modifier.show_render = False
