# SPDX-License-Identifier: GPL-3.0-or-later
"""One squash of the ball, uncorrected and corrected along different axes."""

from collections.abc import Iterator
from math import radians

import bpy
from ball_object import make_ball
from gallery_scene import Staged, lowest
from gallery_tile import Tile

NAME = "corrections"
CASES = (
    ("at rest", 1.0, 1.0, (1, 1, 1)),
    ("Squash 0.5, Preserve 0", 0.5, 0.0, (1, 1, 1)),
    ("Axes 1 1 1", 0.5, 1.0, (1, 1, 1)),
    ("Axes 1 1 0", 0.5, 1.0, (1, 1, 0)),
)
"""Caption, Squash, Preserve, Axes."""
LOW_EYE = 1.5, radians(88.5)
"""Height and tilt of the camera, from where one sees what stands on the ground and what in it."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The ball, squashed to half by the input Squash."""
    ball = make_ball()
    ball.location.z = 1.0
    staged = Staged(scene, ball, (4, 4, 4), margin=0.0)
    scene.camera.location.z, scene.camera.rotation_euler.x = LOW_EYE
    for caption, squash, preserve, axes in CASES:
        staged.put(Squash=squash, Preserve=float(preserve), Axes=axes, Pivot="Bottom")
        depth = -lowest(ball)
        yield staged.tile(f"{caption}, {place_words(depth)}", promised=preserve > 0.0)


def place_words(depth: float) -> str:
    """Where the ball's lowest point is, ``depth`` below the ground."""
    return f"{depth:.2f} in the ground" if depth > 0.005 else "on the ground"
