# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes a lattice by a keyed shape key, to the very volume that a figure asks for (bpy)."""

from collections.abc import Callable

import bpy
import numpy as np
from figure import Array
from gallery_scene import Staged
from surface_measures import enclosed_volume, mesh_arrays

Shape = Callable[[Array, float], Array]
"""Where points (P, 3) of the lattice go: from places that run from -1 to 1 between its outer layers, and a number that
is searched for; to places of the same kind."""

PRECISION = 1e-6
ATTEMPTS = 40


def key_shape(
    staged: Staged, shape: Shape, share: float, between: tuple[float, float], frames: tuple[int, int]
) -> float:
    """Keys the lattice from rest to ``shape`` over the frames. The number that the shape takes is searched for
    ``between`` two, such that the lattice alone leaves ``share`` of the volume; returns it."""
    lattice = staged.lattice
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Shape")
    key.value = 1.0
    rest = np.array([point.co for point in key.data], dtype=np.float64)
    middle, half = (rest.max(axis=0) + rest.min(axis=0)) / 2.0, np.ptp(rest, axis=0) / 2.0
    staged.put(Preserve=0.0)

    def miss(number: float) -> float:
        moved = middle + half * shape((rest - middle) / half, number)
        key.data.foreach_set("co", moved.astype(np.float32).reshape(-1))
        lattice.data.update_tag()
        bpy.context.view_layer.update()
        return _volume(staged) / staged.whole - share

    found = root(miss, *between)
    for frame, value in zip(frames, (0.0, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    staged.put(Preserve=1.0)
    return found


def _volume(staged: Staged) -> float:
    seen = staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return enclosed_volume(*mesh_arrays(seen.data))


def turned(x: Array, y: Array, angle: Array) -> tuple[Array, Array]:
    """Points about the z axis, each by its own angle."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def root(miss: Callable[[float], float], low: float, high: float) -> float:
    """Where ``miss`` is 0 between two numbers at which its signs differ (regula falsi, Illinois)."""
    at_low, at_high = miss(low), miss(high)
    if at_low * at_high > 0.0:
        raise ValueError(f"between {low} and {high} the volume misses by {at_low:.3f} and {at_high:.3f}: no root")
    for _ in range(ATTEMPTS):
        number = (low * at_high - high * at_low) / (at_high - at_low)
        now = miss(number)
        if abs(now) <= PRECISION:
            break
        if now * at_high < 0.0:
            low, at_low = high, at_high
        else:
            at_low /= 2.0
        high, at_high = number, now
    return number
