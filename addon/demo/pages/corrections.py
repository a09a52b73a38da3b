# SPDX-License-Identifier: GPL-3.0-or-later
"""One squash of the ball, uncorrected and corrected along different axes."""

from collections.abc import Iterator

import bpy
from ball_object import make_ball
from gallery_tile import Tile
from stage import set_stage
from surface_measures import enclosed_volume, mesh_arrays
from volume_lattice import add_volume_lattice, find_volume_lattice, set_input

NAME = "corrections"
CASES = (
    ("at rest", 1.0, 1.0, (1, 1, 1)),
    ("the lattice alone", 0.5, 0.0, (1, 1, 1)),
    ("corrected sideways", 0.5, 1.0, (1, 1, 0)),
    ("corrected all around", 0.5, 1.0, (1, 1, 1)),
)
"""Caption, height of the lattice, Preserve, Axes."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The ball's lattice, squashed to half about its bottom."""
    set_stage(scene)
    ball = make_ball()
    ball.location.z = 1.0
    scene.collection.objects.link(ball)
    lattice = add_volume_lattice(ball, (4, 4, 4))
    rest = [point.co_deform.copy() for point in lattice.data.points]
    whole = enclosed_volume(*mesh_arrays(ball.data))
    for caption, height, preserve, axes in CASES:
        for point, before in zip(lattice.data.points, rest):
            point.co_deform.z = (before.z + 0.5) * height - 0.5
        set_input(find_volume_lattice(ball), "Preserve", preserve)
        set_input(find_volume_lattice(ball), "Axes", axes)
        bpy.context.view_layer.update()
        yield Tile(caption, ball.name, whole, whole if preserve else None)
