# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice around half of a bar: whether the rest follows, tears off, or is joined with C0, C1 or C2."""

from collections.abc import Iterator
from math import atan, degrees

import bpy
import numpy as np
from column import SIDES
from figure_stage import View, set_view
from gallery_scene import Staged, clear_stage, draw_lattice, moved_layer, standing_column
from gallery_tile import Tile
from surface_measures import mesh_arrays

NAME = "joints"
COLUMNS = 5
LAYERS = 6
STEP, GROWTH, PRESS = 0.26, 0.11, -0.05
"""How far the first layer is moved aside, how much farther each one above it, and how much lower; in scene units."""
CASES = (
    ("Extend", "Free", "Outside Extend"),
    ("Keep", "Free", "Keep, Joint Free"),
    ("Keep", "C0", "Keep, Joint C0"),
    ("Keep", "C1", "Keep, Joint C1"),
    ("Keep", "C2", "Keep, Joint C2"),
)
"""Inputs Outside and Joint, and a caption."""
VIEW = View(turn=0.0, rise=10.0, height=0.95, distance=9.6, size=(308, 380))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The same points moved, five times."""
    for outside, joint, caption in CASES:
        staged = half_held(scene)
        staged.put(Outside=outside, Joint=joint)
        draw_lattice(staged.lattice)
        yield staged.tile(caption, note="all moves" if outside == "Extend" else jump_words(jumps(staged)))


def half_held(scene: bpy.types.Scene) -> Staged:
    """A column whose upper half is in a lattice, all of whose layers are moved aside and down."""
    clear_stage()
    column = standing_column()
    column.location.x = -0.4
    staged = Staged(scene, column, (2, 2, LAYERS), basis="BERNSTEIN", margin=0.0)
    set_view(scene, VIEW)
    staged.lattice.location.z *= 1.5
    staged.lattice.scale.z *= 0.5
    for layer in range(LAYERS):
        moved_layer(staged.lattice, layer, (STEP + GROWTH * layer, 0.0, PRESS * layer))
    return staged


def jumps(staged: Staged) -> tuple[float, float]:
    """What happens to one upright line of the skin where it enters the lattice, in scene units: how far it is torn
    apart, and by how many degrees it turns. From a cubic through the first points within; below it stands still."""
    seen = staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    line = skin_line(staged.object.data)
    rest, moved = (mesh_arrays(mesh)[0][line].astype(np.float64) for mesh in (staged.object.data, seen.data))
    scale = staged.object.scale.z
    height, aside = scale * rest[:, 2], scale * np.linalg.norm((moved - rest)[:, :2], axis=1)
    face = staged.lattice.location.z - staged.lattice.scale.z / 2.0
    within = np.flatnonzero(height > face)[:8]
    slope, step = np.polyfit(height[within] - face, aside[within], 3)[2:]
    return float(abs(step)), degrees(atan(abs(slope)))


def skin_line(mesh: bpy.types.Mesh) -> np.ndarray:
    """The numbers of the vertices of one upright line of the undeformed column's side, from the bottom up."""
    places = mesh_arrays(mesh)[0]
    line = np.arange(0, len(places) - 2, SIDES)
    wide = np.hypot(places[line, 0], places[line, 1])
    return line[wide > 0.9 * wide.max()]


def jump_words(found: tuple[float, float]) -> str:
    """In few words."""
    step, turn = found
    return f"torn {step:.2f}" if step > 0.005 else f"whole, turns {turn:.0f}°"
