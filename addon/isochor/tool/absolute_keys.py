# SPDX-License-Identifier: GPL-3.0-or-later
"""Absolute shape keys, one a frame, played by their own time: the shape of a frame is its key, to the bit."""

from collections.abc import Callable

import bpy

from . import linear_curve

Fill = Callable[[bpy.types.ShapeKey, int], None]
"""Writes the shape of the frame of this number, counted from 0, into a key."""


def add(obj: bpy.types.Object, first: int, count: int, fill: Fill) -> None:
    """Gives an object without keys one for each frame from ``first`` on, straight between them; beyond it stays in the
    first and last."""
    for number in range(count):
        key = obj.shape_key_add(name=f"Frame {first + number}", from_mix=False)
        key.interpolation = "KEY_LINEAR"
        fill(key, number)
    keys = obj.data.shape_keys
    keys.use_relative = False
    # One key a frame, each where its shape stands: shapes are spaced by rounded steps.
    frames = [float(first + number) for number in range(len(keys.key_blocks))]
    linear_curve.add(keys, "eval_time", frames, [block.frame for block in keys.key_blocks])
