# SPDX-License-Identifier: GPL-3.0-or-later
"""Ferrier's car: four tied lattices, of which the front one crumples; the others keep still to the last bit."""

from collections.abc import Iterator

import bpy
import numpy as np
from car_crash import AT, ENDS, HIGH, HIT, LAST, LOW, NAMES, STOPPED, Crash
from figure_stage import View, set_view
from gallery_scene import draw_lines
from gallery_tile import Tile

NAME = "car"
COLUMNS = 2
VIEW = View(turn=-40.0, rise=19.0, height=0.55, distance=12.2, size=(620, 400))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """The blocks, the moment of the crash, and what is left: without the volume and with it."""
    crash = Crash(scene)
    set_view(scene, VIEW)
    scene.frame_set(HIT)
    drawn = [draw_box(name) for name in NAMES]
    yield tile(crash, "four blocks, tied C1")
    for lines in drawn:
        bpy.data.objects.remove(lines)
    scene.frame_set(STOPPED - 2)
    yield tile(crash, "the front crumples")
    scene.frame_set(LAST)
    crash.put(Preserve=0.0)
    yield tile(crash, "the lattices alone", promised=False)
    crash.put(Preserve=1.0)
    yield tile(crash, "the front keeps the volume")


def tile(crash: Crash, caption: str, promised: bool = True) -> Tile:
    """The stage as it stands."""
    note = f"behind the front moved by {crash.moved_behind():g}"
    return Tile(caption, crash.car.name, crash.whole, crash.whole if promised else None, note)


def draw_box(name: str) -> bpy.types.Object:
    """The edges of what a block holds."""
    number = NAMES.index(name)
    corners = [np.add(AT, ENDS[number : number + 2]), (LOW[0], HIGH[0]), (LOW[1], HIGH[1])]
    places = np.stack(np.meshgrid(*corners, indexing="ij"), axis=-1).transpose(2, 1, 0, 3)
    return draw_lines(f"{name} Lines", places)
