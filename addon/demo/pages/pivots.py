# SPDX-License-Identifier: GPL-3.0-or-later
"""What stays in place in a bend: the bottom, the centre or the top."""

from collections.abc import Iterator
from math import radians

import bpy
from gallery_scene import Staged, standing_column
from gallery_tile import Tile

NAME = "pivots"


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The column, lifted so that nothing goes through the ground."""
    column = standing_column()
    column.location.z = 0.6
    staged = Staged(scene, column, (4, 4, 8))
    yield staged.tile("at rest")
    for pivot in ("Bottom", "Centre", "Top"):
        staged.put(Pivot=pivot, Bend=radians(80.0))
        yield staged.tile(f"Bend 80°, Pivot {pivot}")
