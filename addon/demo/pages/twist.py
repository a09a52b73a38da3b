# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice twisted ever further: alone the column wrings itself thin, corrected it keeps its volume."""

from collections.abc import Iterator
from math import radians

import bpy
from gallery_scene import Staged, standing_column
from gallery_tile import Tile

NAME = "twist"
ANGLES = (60.0, 120.0, 180.0, 240.0)


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Above uncorrected, below corrected."""
    staged = Staged(scene, standing_column(), (4, 4, 5))
    for preserve in (0.0, 1.0):
        for angle in ANGLES:
            staged.put(Twist=radians(angle), Preserve=preserve)
            words = "corrected" if preserve else "lattice alone"
            yield staged.tile(f"Twist {angle:.0f}°, {words}", promised=preserve > 0.0)
