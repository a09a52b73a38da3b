# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 6, a twisting cube: uncorrected, corrected along the vertical, and horizontally, where top and bottom stay
flat."""

from collections.abc import Iterator
from math import acos

import bpy
import numpy as np
from figure import HORIZONTAL, VERTICAL, Array, Figure, alone, corrected
from figure_lattice import root
from figure_stage import View
from gallery_scene import Staged
from gallery_tile import Tile
from models.materials import cube_material
from models.model_object import model_object
from models.twist_cube import make_twist_cube

NAME = "figure-6"
COLUMNS = 5
LAST = 25
FRAMES = (1, 7, 13, 19, 25)
LOSS = 0.66
"""Of the lattice alone in the last frame, as in the paper."""
VIEW = View(turn=-28.0, rise=16.0, height=1.25, distance=14.2, size=(312, 300))


def build(scene: bpy.types.Scene) -> Figure:
    """The cube, twisted from frame 1 to 25."""
    cube = model_object("Cube", make_twist_cube(), cube_material())
    staged = Staged(scene, cube, (4, 4, 4), basis="BERNSTEIN", margin=0.0)
    for frame, angle in ((1, 0.0), (LAST, twist_for(LOSS))):
        staged.key("Twist", angle, frame)
    scene.frame_end = LAST
    rest = np.array([vertex.co[2] for vertex in cube.data.vertices])

    def flatness(positions: Array, plain: Array) -> dict[str, float]:
        """How far the faces are from flat, and the height, in scene units."""
        top, bottom = (float(np.ptp(positions[rest == level, 2])) for level in (rest.max(), rest.min()))
        return {"top off flat": top, "bottom off flat": bottom, "height": float(np.ptp(positions[:, 2]))}

    variants = (alone(), corrected("vertical only", VERTICAL), corrected("horizontal only", HORIZONTAL))
    return Figure(NAME, staged, variants, LAST, flatness)


def twist_for(loss: float) -> float:
    """Angle by which four Bernstein layers must be twisted to lose the share ``loss``.

    A layer at t is scaled by ((1 - t) + t e^(i angle / 3))³, its area by (1 - 2 c t (1 - t))³ with
    c = 1 - cos(angle / 3), and the mean of that over t is 1 - c + 2 c² / 5 - 2 c³ / 35.
    """
    found = root(lambda c: c - 0.4 * c**2 + 2.0 * c**3 / 35.0 - loss, 0.0, 2.0)
    return 3.0 * acos(1.0 - found)


def pictures(figure: Figure) -> Iterator[Tile]:
    """A row a variant."""
    for variant in figure.variants:
        for frame in FRAMES:
            yield figure.tile(variant, frame, f"frame {frame}, {variant.name}", flat_words)


def flat_words(found: dict[str, float]) -> str:
    """What is said of the top."""
    height = found["top off flat"]
    return f"top {height:.2f} off flat" if height else "top exactly flat"
