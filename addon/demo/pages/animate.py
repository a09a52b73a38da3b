# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs of the panel Animate, one after the other, on a striped column."""

from collections.abc import Iterator
from math import radians

import bpy
from gallery_scene import Staged, standing_column
from gallery_tile import Tile

NAME = "animate"
NEUTRAL = {"Squash": 1.0, "Taper": 0.0, "Twist": 0.0, "Bend": 0.0, "Bend_Direction": 0.0}
CASES = (
    ("at rest", {}),
    ("Squash 0.6", {"Squash": 0.6}),
    ("Squash 1.3", {"Squash": 1.3}),
    ("Taper -0.8", {"Taper": -0.8}),
    ("Twist 180°", {"Twist": radians(180.0)}),
    ("Bend 90°", {"Bend": radians(90.0)}),
    ("Bend 60°, Bend Direction -90°", {"Bend": radians(60.0), "Bend_Direction": radians(-90.0)}),
    ("all four", {"Squash": 1.2, "Taper": -0.6, "Twist": radians(120.0), "Bend": radians(60.0)}),
)
"""Caption, and what differs from rest."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The column, its volume kept by a correction sideways."""
    staged = Staged(scene, standing_column(), (4, 4, 8))
    for caption, inputs in CASES:
        staged.put(**(NEUTRAL | inputs))
        yield staged.tile(caption)
