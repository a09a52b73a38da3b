# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing jelly: the lattice simulated as an elastic body, its volume kept."""

from collections.abc import Iterator

import bpy
from gallery_tile import Tile
from make_jelly import make_scene
from surface_measures import enclosed_volume, mesh_arrays

NAME = "jelly"
FRAMES = (1, 12, 16, 19, 23, 28, 34, 90)


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Some frames of one fall, to rest."""
    ball = make_scene()
    whole = enclosed_volume(*mesh_arrays(ball.data))
    for frame in FRAMES:
        scene.frame_set(frame)
        yield Tile(f"frame {frame}", ball.name, whole, whole)
