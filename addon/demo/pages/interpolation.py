# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Interpolation: how far a control point reaches, and what becomes of vertices outside the lattice."""

from collections.abc import Iterator
from math import radians

import bpy
from gallery_scene import Staged, clear_stage, draw_lattice, standing_column
from gallery_tile import Tile

NAME = "interpolation"
ROWS, LAYER = 12, 7
"""Layers of points up the column, and the one that is moved."""
SHIFT = 0.8
"""How far, in scene units."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """One layer of points moved sideways under either basis, then a lattice around the lower part only."""
    for basis, words in (("BERNSTEIN", "Bernstein"), ("BSPLINE", "B-Spline")):
        staged = fresh(scene, (4, 4, ROWS), basis)
        for point in list(staged.lattice.data.points)[16 * LAYER : 16 * (LAYER + 1)]:
            point.co_deform.x += SHIFT / staged.lattice.scale.x
        draw_lattice(staged.lattice, LAYER)
        yield staged.tile(f"{words}: one layer moved")
    for outside in ("Keep", "Extend"):
        staged = fresh(scene, (4, 4, 5), "BERNSTEIN")
        staged.lattice.location.z *= 0.6
        staged.lattice.scale.z *= 0.6
        staged.put(Outside=outside, Bend=radians(50.0))
        draw_lattice(staged.lattice)
        yield staged.tile(f"Outside {outside}: lattice too low")


def fresh(scene: bpy.types.Scene, resolution: tuple[int, int, int], basis: str) -> Staged:
    """A column at rest on an empty stage."""
    clear_stage()
    return Staged(scene, standing_column(), resolution, basis=basis)
