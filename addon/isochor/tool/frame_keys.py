# SPDX-License-Identifier: GPL-3.0-or-later
"""One relative shape key a frame, each at 1 on its own frame and at 0 from the frames beside it on.

On a frame exactly one key acts, so the shape is that key's; between two frames the shape goes straight from one to the
other. Relative keys leave other keys of the object alone, and other programs read them.
"""

import bpy
import numpy as np
from numpy.typing import NDArray

from . import animation_paths, linear_curve


def add(obj: bpy.types.Object, name: str, frames: list[float], shapes: list[NDArray[np.float32]]) -> list[str]:
    """Adds the keys to a mesh or lattice object, (points, 3) a frame, ascending; the names that Blender gave them. An
    object without keys gets a basis, its own shape, first."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    blocks = []
    for frame, shape in zip(frames, shapes, strict=True):
        block = obj.shape_key_add(name=f"{name} {frame:g}", from_mix=False)
        block.points.foreach_set("co", np.ascontiguousarray(shape, np.float32).reshape(-1))
        # Blender 5 starts a key at 1, earlier ones at 0.
        block.value = 0.0
        block.relative_key = obj.data.shape_keys.reference_key
        blocks.append(block)
    for index, block in enumerate(blocks):
        around = slice(max(index - 1, 0), index + 2)
        values = [float(frame == frames[index]) for frame in frames[around]]
        linear_curve.add(obj.data.shape_keys, f"{animation_paths.of_key(block)}.value", frames[around], values)
    return [block.name for block in blocks]


def remove(obj: bpy.types.Object, blocks: list[bpy.types.ShapeKey], basis_too: bool) -> None:
    """Takes these keys and their curves away; ``basis_too``: and the basis, where nothing else is left."""
    if not blocks:
        return
    keys = obj.data.shape_keys
    animation_paths.remove(keys, [animation_paths.of_key(block) for block in blocks])
    for block in blocks:
        obj.shape_key_remove(block)
    if basis_too and len(keys.key_blocks) == 1:
        obj.shape_key_clear()
