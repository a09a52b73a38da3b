# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the ball's lattice, calibrated on Blender's own Lattice modifier, and the bounce's key frames (bpy)."""

from collections.abc import Iterable

import bounce
import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray
from surface_measures import SurfaceMeasure, measure_evaluated

Heights = NDArray[np.float64]
PLAIN_MODIFIER = "Plain Lattice"


def add_plain_lattice(ball: bpy.types.Object, lattice: bpy.types.Object) -> bpy.types.LatticeModifier:
    """Blender's own Lattice modifier on `ball`: the uncorrected deformation, to measure and to compare with."""
    modifier = ball.modifiers.new(PLAIN_MODIFIER, "LATTICE")
    modifier.object = lattice
    return modifier


def shape_lattice(ball: bpy.types.Object, lattice: bpy.types.Object) -> None:
    """Adds the shape keys "Squash" (loses DEEPEST_LOSS at value 1) and "Stretch" (gains STRETCH_GAIN).

    Both move the lattice's layers up and down only and leave the ball's lowest point where it is, on the ground.
    The volume is linear in the heights of the layers, so one trial measurement gives the exact scale.
    """
    lattice.shape_key_add(name="Basis")
    heights = _layer_heights(lattice)
    _add_scaled_key(ball, lattice, "Squash", bounce.graded_heights(heights), 1 - bounce.DEEPEST_LOSS)
    _add_scaled_key(ball, lattice, "Stretch", heights - heights[0], 1 + bounce.STRETCH_GAIN)


def _layer_heights(lattice: bpy.types.Object) -> Heights:
    """Rest z (nw,) of the lattice's layers, in the lattice's own space; points are stored u fastest, w slowest."""
    points = lattice.data.points
    layer = lattice.data.points_u * lattice.data.points_v
    return np.array([points[index].co[2] for index in range(0, len(points), layer)], dtype=np.float64)


def _add_scaled_key(
    ball: bpy.types.Object, lattice: bpy.types.Object, name: str, heights: Heights, volume_share: float
) -> None:
    """Key with layers at `heights`, scaled and moved so that the ball keeps `volume_share` and its lowest point."""
    rest = _measure_plain(ball, lattice)
    key = lattice.shape_key_add(name=name)
    _set_layer_heights(lattice, key, heights)
    key.value = 1.0
    trial = _measure_plain(ball, lattice)
    scale = volume_share * rest.volume / trial.volume
    to_lattice = lattice.matrix_world.inverted()
    rest_low, trial_low = ((to_lattice @ _at_height(lattice, m.lowest)).z for m in (rest, trial))
    _set_layer_heights(lattice, key, scale * (heights - trial_low) + rest_low)
    key.value = 0.0


def _at_height(lattice: bpy.types.Object, height: float) -> Vector:
    point = lattice.matrix_world.translation.copy()
    point.z = height
    return point


def _set_layer_heights(lattice: bpy.types.Object, key: bpy.types.ShapeKey, heights: Heights) -> None:
    layer = lattice.data.points_u * lattice.data.points_v
    for index, point in enumerate(key.data):
        point.co.z = heights[index // layer]


def _measure_plain(ball: bpy.types.Object, lattice: bpy.types.Object) -> SurfaceMeasure:
    """The ball under Blender's own Lattice modifier alone."""
    others = [modifier for modifier in ball.modifiers if modifier.show_viewport]
    for modifier in others:
        modifier.show_viewport = False
    plain = add_plain_lattice(ball, lattice)
    try:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        return measure_evaluated(ball, depsgraph)
    finally:
        ball.modifiers.remove(plain)
        for modifier in others:
            modifier.show_viewport = True


def animate(scene: bpy.types.Scene, rig: bpy.types.Object, lattice: bpy.types.Object) -> None:
    """Keys the fall of `rig` and the lattice's shape keys; marks the frames of MARKED_LOSSES on the timeline."""
    scene.frame_start, scene.frame_end = bounce.FRAME_START, bounce.FRAME_END
    scene.render.fps = bounce.FRAMES_PER_SECOND
    for frame, height in bounce.FALL:
        rig.location.z = height
        rig.keyframe_insert("location", index=2, frame=frame)
    keys = lattice.data.shape_keys
    _key_values(keys.key_blocks["Squash"], [(frame, loss / bounce.DEEPEST_LOSS) for frame, loss in bounce.SQUASH])
    _key_values(keys.key_blocks["Stretch"], bounce.STRETCH)
    _shape_fall(_curve(rig, "location"))
    _shape_squash(_curve(keys, 'key_blocks["Squash"].value'))
    for frame, loss in bounce.MARKED_LOSSES.items():
        scene.timeline_markers.new(f"{100 * loss:.0f} %", frame=frame)


def _key_values(key: bpy.types.ShapeKey, values: Iterable[tuple[int, float]]) -> None:
    for frame, value in values:
        key.value = value
        key.keyframe_insert("value", frame=frame)


def _curve(animated: bpy.types.ID, data_path: str) -> bpy.types.FCurve:
    """The F-curve of `data_path`, through layers and strips: action.fcurves is gone since Blender 5.0."""
    animation = animated.animation_data
    channels = animation.action.layers[0].strips[0].channelbag(animation.action_slot)
    return next(curve for curve in channels.fcurves if curve.data_path == data_path)


def _shape_fall(curve: bpy.types.FCurve) -> None:
    """Free fall and rise are parabolas; on the ground the rig rests."""
    fall, rest, rise, _end = curve.keyframe_points
    fall.interpolation, fall.easing = "QUAD", "EASE_IN"
    rest.interpolation = "CONSTANT"
    rise.interpolation, rise.easing = "QUAD", "EASE_OUT"


def _shape_squash(curve: bpy.types.FCurve) -> None:
    """Smooth between the marked values, but abrupt at contact and at take-off."""
    for point in curve.keyframe_points:
        point.interpolation = "BEZIER"
        point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"
    for point in (curve.keyframe_points[0], curve.keyframe_points[-1]):
        point.handle_left_type = point.handle_right_type = "VECTOR"
    curve.update()
