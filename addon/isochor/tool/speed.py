# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's speed in the world, sampled frame by frame and kept as a keyed property, which drivers can read."""

from collections.abc import Callable

import bpy
import numpy as np
from numpy.typing import NDArray

from . import drivers

PROPERTY = "isochor_speed"
PATH = f'["{PROPERTY}"]'

Sample = Callable[[bpy.types.Depsgraph], NDArray[np.float64]]


def sampled(context: bpy.types.Context, start: int, end: int, samples: list[Sample]) -> list[NDArray[np.float64]]:
    """What each of ``samples`` gives at every frame from ``start`` to ``end``, inclusive, stacked by frame. The scene
    comes back to the frame at which it stood."""
    scene = context.scene
    before = (scene.frame_current, scene.frame_subframe)
    found: list[list[NDArray[np.float64]]] = [[] for _ in samples]
    manager = context.window_manager
    manager.progress_begin(start, end + 1)
    try:
        for frame in range(start, end + 1):
            scene.frame_set(frame)
            depsgraph = context.evaluated_depsgraph_get()
            for rows, sample in zip(found, samples, strict=True):
                rows.append(sample(depsgraph))
            manager.progress_update(frame)
    finally:
        scene.frame_set(before[0], subframe=before[1])
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
    obj.keyframe_insert(PATH, frame=start)
    curve = drivers.keys_of(obj, PATH)
    if curve is None:
        raise RuntimeError(f"Blender made no curve of keys for {PATH} of {obj.name!r}")
    curve.keyframe_points.clear()
    curve.keyframe_points.add(len(speeds))
    frames = np.arange(start, start + len(speeds), dtype=np.float64)
    curve.keyframe_points.foreach_set("co", np.column_stack([frames, speeds]).astype(np.float32).reshape(-1))
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    curve.update()
    obj.update_tag()
