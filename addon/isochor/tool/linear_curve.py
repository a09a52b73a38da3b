# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that go straight from key to key, written without Blender's operators."""

import bpy
import numpy as np

from . import animation_paths

LINEAR = 1
"""Number of the interpolation in Blender's list, for ``foreach_set``."""


def add(owner: bpy.types.ID, path: str, frames: list[float], values: list[float]) -> None:
    """Keys the property at this data path of ``owner`` at these frames, ascending; keys and drivers that it had go."""
    animation_paths.remove(owner, [path])
    curves = _channelbag(owner).fcurves
    stale = curves.find(path)
    if stale is not None:
        # As of a key that was removed while another owner of the same action still had it.
        curves.remove(stale)
    curve = curves.new(path)
    points = np.stack([frames, values], axis=-1).astype(np.float32)
    curve.keyframe_points.add(len(points))
    curve.keyframe_points.foreach_set("co", points.reshape(-1))
    curve.keyframe_points.foreach_set("interpolation", np.full(len(points), LINEAR, np.int32))
    curve.update()


def _channelbag(owner: bpy.types.ID) -> bpy.types.ActionChannelbag:
    """Where the curves of this data are, made where there is nothing yet."""
    animation = owner.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{owner.name} Action")
    action = animation.action
    if animation.action_slot is None:
        animation.action_slot = action.slots.new(id_type=owner.id_type, name=owner.name)
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(animation.action_slot, ensure=True)
