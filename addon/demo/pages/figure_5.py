# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 5, a screwdriver redesigned: its handle pinched, the volume given back sideways or lengthwise."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import HORIZONTAL, VERTICAL, Array, Figure, alone, corrected, extents
from figure_lattice import key_shape, turned
from figure_stage import View
from gallery_scene import Staged
from gallery_tile import Tile
from models.materials import screwdriver_material
from models.model_object import model_object
from models.screwdriver import make_screwdriver

NAME = "figure-5"
COLUMNS = 4
LAST = 13
SHARE = 0.6
VIEW = View(turn=-25.0, rise=15.0, height=1.42, distance=8.7, size=(392, 480))


def build(scene: bpy.types.Scene) -> Figure:
    """The screwdriver, redesigned from frame 1 to 13."""
    tool = model_object("Screwdriver", make_screwdriver(), screwdriver_material())
    staged = Staged(scene, tool, (4, 4, 12), margin=0.0)
    key_shape(staged, redesigned, SHARE, (0.0, 0.95), (1, LAST))
    scene.frame_end = LAST
    variants = (alone(), corrected("horizontal only", HORIZONTAL), corrected("vertical only", VERTICAL))
    return Figure(NAME, staged, variants, LAST, extents)


def redesigned(points: Array, pinch: float) -> Array:
    """The handle pinched in its middle and turned against the blade."""
    x, y, z = points.T
    width = 1.0 - pinch * np.exp(-(((z - 0.42) / 0.22) ** 2))
    across, back = turned(width * x, width * y, 1.2 * np.clip(z, 0.0, 1.0))
    return np.stack([across, back, z], axis=1)


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest, the lattice alone, and both corrections."""
    yield figure.tile(figure.variants[0], 1, "at rest", size_words)
    for variant in figure.variants:
        yield figure.tile(variant, LAST, variant.name, size_words)


def size_words(found: dict[str, float]) -> str:
    """How thick the handle and how long the whole is."""
    return f"{found['width']:.2f} thick, {found['height']:.2f} long"
