# SPDX-License-Identifier: GPL-3.0-or-later
"""One relative shape key a frame, each at 1 on its own frame and at 0 from the frames beside it on.

On a frame exactly one key acts, so the shape is that key's; between two frames the shape goes straight from one to the
other. Relative keys leave other keys of the object alone, and other programs read them.
"""

import bpy
import numpy as np
from numpy.typing import NDArray

from . import animation_paths

LINEAR = 1
"""Number of the interpolation in Blender's list, for ``foreach_set``."""


def add(obj: bpy.types.Object, name: str, frames: list[float], shapes: list[NDArray[np.float32]]) -> list[str]:
    """Adds the keys to a mesh or lattice object, (points, 3) a frame, ascending; the names that Blender gave them."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    blocks = []
    for frame, shape in zip(frames, shapes, strict=True):
        block = obj.shape_key_add(name=f"{name} {frame:g}", from_mix=False)
        block.points.foreach_set("co", np.ascontiguousarray(shape, np.float32).reshape(-1))
        # Blender 5 starts a key at 1, earlier ones at 0.
        block.value = 0.0
        blocks.append(block)
    bag = _channelbag(obj.data.shape_keys)
    for index, block in enumerate(blocks):
        _add_curve(bag, block, frames, index)
    return [block.name for block in blocks]


def remove(obj: bpy.types.Object, names: list[str], basis_too: bool) -> None:
    """Takes these keys and their curves away, those that are there still; ``basis_too``: and the basis, where nothing
    else is left."""
    keys = obj.data.shape_keys
    if keys is None:
        return
    blocks = [keys.key_blocks[name] for name in names if name in keys.key_blocks]
    animation_paths.remove(keys, [animation_paths.of_key(block) for block in blocks])
    for block in blocks:
        obj.shape_key_remove(block)
    if basis_too and len(keys.key_blocks) == 1:
        obj.shape_key_clear()


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


def _add_curve(bag: bpy.types.ActionChannelbag, block: bpy.types.ShapeKey, frames: list[float], index: int) -> None:
    around = range(max(index - 1, 0), min(index + 2, len(frames)))
    points = [(frames[place], 1.0 if place == index else 0.0) for place in around]
    curve = bag.fcurves.new(f"{animation_paths.of_key(block)}.value")
    curve.keyframe_points.add(len(points))
    curve.keyframe_points.foreach_set("co", np.array(points, np.float32).reshape(-1))
    curve.keyframe_points.foreach_set("interpolation", np.full(len(points), LINEAR, np.int32))
    curve.update()
