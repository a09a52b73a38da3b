# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 4, squared: a casket pressed into a square block, its volume given back sideways or upwards."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import HORIZONTAL, VERTICAL, Array, Figure, alone, corrected, extents
from figure_lattice import key_shape
from figure_stage import View
from gallery_scene import Staged
from gallery_tile import Tile
from models.casket import make_casket
from models.materials import casket_material
from models.model_object import model_object

NAME = "figure-4"
COLUMNS = 4
LAST = 13
SHARE = 0.5
"""Of the volume that the lattice alone leaves: the paper's caption says 40 %, its text 60 %."""
VIEW = View(turn=35.0, rise=14.0, height=0.74, distance=10.4, size=(392, 360))


def build(scene: bpy.types.Scene) -> Figure:
    """The casket, squared from frame 1 to 13."""
    casket = model_object("Casket", make_casket(), casket_material())
    staged = Staged(scene, casket, (5, 5, 5), basis="BERNSTEIN", margin=0.0)
    key_shape(staged, squared, SHARE, (0.2, 1.2), (1, LAST))
    scene.frame_end = LAST
    variants = (alone(), corrected("horizontal only", HORIZONTAL), corrected("vertical only", VERTICAL))
    return Figure(NAME, staged, variants, LAST, extents)


def squared(points: Array, width: float) -> Array:
    """As wide as deep, the sides drawn in and the corners out, so that the edges stand sharp."""
    x, y, z = points.T
    hollow = 1.0 + 0.35 * (x * y) ** 2 - 0.22 * (1.0 - z**2)
    return np.stack([0.7 * width * hollow * x, width * hollow * y, z], axis=1)


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest, the lattice alone, and both corrections."""
    yield figure.tile(figure.variants[0], 1, "at rest", size_words)
    for variant in figure.variants:
        yield figure.tile(variant, LAST, variant.name, size_words)


def size_words(found: dict[str, float]) -> str:
    """How wide and high the block is."""
    return f"{found['width']:.2f} wide, {found['height']:.2f} high"
