# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices of one layer and of one row: flat lettering warped in its plane, its area kept, and along a line."""

from collections.abc import Callable, Iterator

import bpy
import numpy as np
from figure import Array
from figure_stage import View, set_view
from gallery_scene import Staged, clear_stage, draw_lattice
from gallery_tile import Tile
from models.materials import sign_material
from models.model_object import model_object
from models.sign import make_sign

NAME = "flat"
COLUMNS = 2
PLANE, LINE = (5, 3, 1), (7, 1, 1)
"""Resolutions with ones."""
VIEW = View(turn=0.0, rise=52.0, height=0.0, distance=18.5, size=(780, 330))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """At rest, in the plane with and without the area kept, and along a line."""
    staged = lettered(scene, PLANE)
    lines = draw_lattice(staged.lattice)
    yield staged.tile("5 x 3 x 1 points around flat letters")
    bpy.data.objects.remove(lines)
    shape(staged, fan)
    staged.put(Preserve=0.0)
    draw_lattice(staged.lattice)
    yield staged.tile("a fan, the lattice alone: the area grows", promised=False)
    staged.put(Preserve=1.0)
    yield staged.tile("the same with volume: the area is kept")
    staged = lettered(scene, LINE)
    shape(staged, wave)
    draw_lattice(staged.lattice)
    yield staged.tile("7 x 1 x 1 points: a wave along a line")


def lettered(scene: bpy.types.Scene, resolution: tuple[int, int, int]) -> Staged:
    """The letters, flat on the ground. Their thickness stays, so what is kept of the volume is the area."""
    clear_stage()
    sign = model_object("Sign", make_sign(), sign_material())
    staged = Staged(scene, sign, resolution, basis="BERNSTEIN", margin=0.02)
    staged.put(Outside="Extend")
    set_view(scene, VIEW)
    return staged


def shape(staged: Staged, places: Callable[[Array], Array]) -> None:
    """Moves the lattice's points: from places that run from -1 to 1 along x and y, to places of the same kind."""
    points = staged.lattice.data.points
    half = np.array(staged.lattice.scale) / 2.0
    rest = np.array([point.co for point in points])
    moved = places(2.0 * rest) * half
    for point, place in zip(points, moved / np.array(staged.lattice.scale)):
        point.co_deform = place
    bpy.context.view_layer.update()


def fan(places: Array) -> Array:
    """Spread out at the top and arched."""
    x, y, z = places.T
    return np.stack([x * (1.0 + 0.18 * y), 1.35 * y + 0.9 - 1.5 * x**2, z], axis=1)


def wave(places: Array) -> Array:
    """Up and down, less at the ends."""
    x, y, z = places.T
    return np.stack([x, y + 1.9 * np.sin(1.5 * np.pi * x) * (1.0 - 0.6 * x**2), z], axis=1)
