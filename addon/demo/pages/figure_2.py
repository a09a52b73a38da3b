# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 2, a cup sculpted by its lattice, with general correction: waist, flare and a lean to one side."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import GENERAL, Array, Figure, alone, corrected
from figure_lattice import key_shape, turned
from figure_stage import View
from gallery_scene import Staged, draw_lattice
from gallery_tile import Tile
from models.cup import make_cup
from models.materials import cup_material
from models.model_object import model_object

NAME = "figure-2"
COLUMNS = 3
LAST = 13
AXIS = -0.271
"""Where the cup's own axis is in x between the lattice's ends, which hold the handle too."""
SHARE = 0.62
"""Of the volume that the lattice alone leaves; the paper names none."""
VIEW = View(turn=-18.0, rise=24.0, height=0.62, distance=6.6, size=(520, 440))


def build(scene: bpy.types.Scene) -> Figure:
    """The cup, sculpted from frame 1 to 13."""
    staged = Staged(scene, model_object("Cup", make_cup(), cup_material()), (4, 4, 5), basis="BERNSTEIN", margin=0.0)
    key_shape(staged, sculpted, SHARE, (0.0, 0.9), (1, LAST))
    scene.frame_end = LAST
    return Figure(NAME, staged, (alone(), corrected("general correction", GENERAL)), LAST)


def sculpted(points: Array, squeeze: float) -> Array:
    """A waist, a flared and turned lip, the whole leaning."""
    x, y, z = points[:, 0] - AXIS, points[:, 1], points[:, 2]
    up = (z + 1.0) / 2.0
    width = 1.0 - squeeze * np.sin(np.pi * up) ** 0.8 + 0.1 * up**4
    across, back = turned(width * x, width * y, -0.55 * up)
    return np.stack([across + AXIS + 0.1 * up**2, back, z + 0.1 * up**2 * x], axis=1)


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest in its lattice, the lattice alone, corrected."""
    plain, general = figure.variants
    figure.show(plain, 1)
    lines = draw_lattice(figure.staged.lattice)
    yield figure.tile(plain, 1, "at rest")
    bpy.data.objects.remove(lines)
    for variant in (plain, general):
        yield figure.tile(variant, LAST, variant.name)
