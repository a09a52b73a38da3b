# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 5, a screwdriver redesigned: the handle pinched and the shaft drawn, its volume given back sideways or along."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import HORIZONTAL, VERTICAL, Array, Figure, alone, corrected
from figure_lattice import key_shape
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
VIEW = View(turn=-25.0, rise=15.0, height=1.4, distance=10.4, size=(392, 520))


def build(scene: bpy.types.Scene) -> Figure:
    """The screwdriver, redesigned from frame 1 to 13."""
    tool = model_object("Screwdriver", make_screwdriver(), screwdriver_material())
    staged = Staged(scene, tool, (4, 4, 10), margin=0.0)
    key_shape(staged, redesigned, SHARE, (0.0, 0.95), (1, LAST))
    scene.frame_end = LAST
    variants = (alone(), corrected("horizontal only", HORIZONTAL), corrected("vertical only", VERTICAL))
    return Figure(NAME, staged, variants, LAST)


def redesigned(points: Array, pinch: float) -> Array:
    """The handle pinched in its middle and turned against the blade."""
    x, y, z = points.T
    width = 1.0 - pinch * np.exp(-(((z - 0.44) / 0.3) ** 2))
    turn = 1.2 * np.clip(z, 0.0, 1.0)
    return np.stack([width * (x * np.cos(turn) - y * np.sin(turn)), width * (x * np.sin(turn) + y * np.cos(turn)), z], 1)


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest, the lattice alone, and both corrections."""
    yield figure.tile(figure.variants[0], 1, "at rest")
    for variant in figure.variants:
        yield figure.tile(variant, LAST, variant.name)
