# SPDX-License-Identifier: GPL-3.0-or-later
"""Boxes of any direction, and lattices of any degree: the smallest box of a thing that leans, and one drag under a
linear, a quadratic, a cubic and a lattice of degree 6."""

from collections.abc import Iterator
from math import radians

import bpy
import numpy as np
from column import HEIGHT
from figure_stage import View, set_view
from gallery_scene import Staged, clear_stage, draw_lattice, moved_layer, standing_column
from gallery_tile import Tile
from surface_measures import mesh_arrays

NAME = "degrees"
COLUMNS = 3
BOXES = (("WORLD", "Fit World"), ("ORIENTED", "Fit Oriented: the smallest box"))
DEGREES = {2: "linear", 3: "quadratic", 4: "cubic", 7: "degree 6"}
"""Layers of points up the column, and the degree that they make."""
DRAG = np.array([0.62, 0.0, -0.25])
"""Of the top layer, in scene units."""
VIEW = View(turn=0.0, rise=13.0, height=0.98, distance=9.8, size=(520, 380))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Two boxes around a leaning column, then four degrees."""
    for fit, caption in BOXES:
        staged = leaning(scene, fit)
        draw_lattice(staged.lattice)
        yield staged.tile(caption, note=f"the box is {box_share(staged):.1f} times as large as the column")
    for layers, word in DEGREES.items():
        staged = dragged(scene, layers)
        note = f"at half height {100.0 * moved_halfway(staged):.1f} % of the drag"
        draw_lattice(staged.lattice)
        yield staged.tile(f"{layers} layers: {word}", note=note)


def leaning(scene: bpy.types.Scene, fit: str) -> Staged:
    """A column that leans both ways, in its box."""
    clear_stage()
    column = standing_column()
    column.rotation_euler = (radians(24.0), radians(38.0), radians(20.0))
    column.location = (-0.7, 0.4, 0.42)
    staged = Staged(scene, column, (2, 2, 2), basis="BERNSTEIN", margin=0.0, fit=fit)
    set_view(scene, VIEW)
    return staged


def box_share(staged: Staged) -> float:
    """Volume of the lattice's box in volumes of the object."""
    box = abs(staged.lattice.matrix_world.determinant())
    return float(box / (staged.whole * staged.object.matrix_world.determinant()))


def dragged(scene: bpy.types.Scene, layers: int) -> Staged:
    """An upright column, the top layer of its lattice dragged aside and down."""
    clear_stage()
    staged = Staged(scene, standing_column(), (2, 2, layers), basis="BERNSTEIN", margin=0.0)
    set_view(scene, VIEW)
    moved_layer(staged.lattice, layers - 1, DRAG)
    return staged


def moved_halfway(staged: Staged) -> float:
    """How far the lattice alone moves the column's skin at half its height down, as a share of the drag."""
    staged.put(Preserve=0.0)
    rest = mesh_arrays(staged.object.data)[0].astype(np.float64)
    seen = staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    moved = mesh_arrays(seen.data)[0] - rest
    staged.put(Preserve=1.0)
    order = np.argsort(rest[:, 2])
    halfway = np.interp(HEIGHT / 2.0, rest[order, 2], moved[order, 2])
    return float(halfway * staged.object.scale.z / DRAG[2])
