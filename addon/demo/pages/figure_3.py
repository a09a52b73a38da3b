# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 3, flattened: a casket drawn out into a slab of three times its volume; corrected horizontally it is flatter
still."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import HORIZONTAL, Array, Figure, alone, corrected, extents
from figure_lattice import key_shape
from figure_stage import View
from gallery_scene import Staged
from gallery_tile import Tile
from models.casket import make_casket
from models.materials import casket_material
from models.model_object import model_object

NAME = "figure-3"
COLUMNS = 4
LAST = 13
SHARE = 3.0
ACROSS = (0.0, 1.0, 0.0)
"""Only along the direction that was flattened, which is horizontal too."""
VIEW = View(turn=52.0, rise=13.0, height=1.35, distance=13.5, size=(392, 400))


def build(scene: bpy.types.Scene) -> Figure:
    """The casket, flattened from frame 1 to 13."""
    casket = model_object("Casket", make_casket(), casket_material())
    staged = Staged(scene, casket, (5, 4, 5), basis="BERNSTEIN", margin=0.0)
    key_shape(staged, flattened, SHARE, (1.0, 4.0), (1, LAST))
    scene.frame_end = LAST
    variants = (alone(), corrected("horizontal", HORIZONTAL), corrected("front to back", ACROSS))
    return Figure(NAME, staged, variants, LAST, extents)


def flattened(points: Array, tall: float) -> Array:
    """Pressed flat from the front and the back, drawn up and to both sides, most at the corners."""
    x, y, z = points.T
    wide, up = 2.2 * x * (1.0 + 0.08 * z**2), tall * (z + 1.0) * (1.0 + 0.06 * x**2) - 1.0
    return np.stack([wide, y * (0.56 + 0.08 * (x * z) ** 2), up], axis=1)


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest, the lattice alone, corrected."""
    plain = figure.variants[0]
    states = ((plain, 1, "at rest"), *((variant, LAST, variant.name) for variant in figure.variants))
    for variant, frame, caption in states:
        yield figure.tile(variant, frame, caption, size_words)


def size_words(found: dict[str, float]) -> str:
    """How thick and high the slab is."""
    return f"{found['depth']:.2f} thick, {found['height']:.2f} high"
