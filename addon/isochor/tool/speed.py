# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's speed in the world, sampled frame by frame and kept as a keyed property, which drivers can read."""

from collections.abc import Callable

import bpy
import numpy as np
from numpy.typing import NDArray

from . import animation_paths, lattices, linear_curve
from .frames import frame_kept

PROPERTY = "isochor_speed"
PATH = f'["{PROPERTY}"]'

Sample = Callable[[bpy.types.Depsgraph], NDArray[np.float64]]


def sampled(context: bpy.types.Context, start: int, end: int, samples: list[Sample]) -> list[NDArray[np.float64]]:
    """What each of ``samples`` gives at every frame from ``start`` to ``end``, inclusive, stacked by frame. The scene
    comes back to the frame at which it stood."""
    scene = context.scene
    found: list[list[NDArray[np.float64]]] = [[] for _ in samples]
    manager = context.window_manager
    manager.progress_begin(start, end + 1)
    try:
        with frame_kept(scene):
            for frame in range(start, end + 1):
                scene.frame_set(frame)
                depsgraph = context.evaluated_depsgraph_get()
                for rows, sample in zip(found, samples, strict=True):
                    rows.append(sample(depsgraph))
                manager.progress_update(frame)
    finally:
        manager.progress_end()
    return [np.array(rows) for rows in found]


def velocities(places: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """(F - 2, 3) world units a second at every frame but the first and last of places (F, 3), ``rate`` frames a second:
    from the frame before to the frame after."""
    return np.asarray((places[2:] - places[:-2]) * (rate / 2.0))


def keep(obj: bpy.types.Object, start: int, speeds: NDArray[np.float64]) -> None:
    """Gives the object the property, keyed with speeds (F,) from the frame ``start`` on, in place of older keys."""
    if PROPERTY not in obj:
        obj[PROPERTY] = 0.0
    obj.id_properties_ui(PROPERTY).update(min=0.0, description="World units a second, sampled by Squash from Speed")
    linear_curve.add(obj, PATH, [float(frame) for frame in range(start, start + len(speeds))], speeds.tolist())
    obj.update_tag()


def forget(obj: bpy.types.Object) -> None:
    """Takes the property with its keys away, unless another driver may read it."""
    if PROPERTY not in obj or lattices.is_used(obj) or _is_read_by_itself(obj):
        return
    animation_paths.remove(obj, [PATH])
    del obj[PROPERTY]


def _is_read_by_itself(obj: bpy.types.Object) -> bool:
    curves = [] if obj.animation_data is None else obj.animation_data.drivers
    variables = [variable for curve in curves for variable in curve.driver.variables]
    return any(target.data_path == PATH for variable in variables for target in variable.targets)
