# SPDX-License-Identifier: GPL-3.0-or-later
"""Anything that is made of points: lettering, a curve, hair and a point cloud in one lattice."""

from collections.abc import Iterator
from math import cos, sin
from typing import Any

import bpy
from blender_session import DemoError
from figure_stage import View, set_view
from gallery_scene import draw_lattice
from gallery_tile import Tile
from models.things import make_cloud, make_coil, make_hair, make_text
from stage import set_stage
from surface_measures import drawn_arrays, enclosed_volume
from volume_lattice import find_volume_lattice, get_input, set_input

NAME = "kinds"
COLUMNS = 2
MAKERS = (make_text, make_coil, make_hair, make_cloud)
PLACES = (-2.35, -0.55, 0.85, 2.3)
RESOLUTION = (8, 2, 3)
ARC = 1.7
"""Angle of the hill over which the row is bent, in radians."""
VIEW = View(turn=12.0, rise=14.0, height=1.05, distance=19.5, size=(780, 420))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """At rest and bent; what is measured is the lettering."""
    objects = row(scene)
    text = objects[0]
    lattice = wrapped(objects)
    for obj in objects[:2]:
        set_input(find_volume_lattice(obj), "Close Holes", True)
    bpy.context.view_layer.update()
    whole = text_volume(text)
    lines = draw_lattice(lattice)
    yield Tile("text, curve, hair, point cloud: one lattice", text.name, whole, whole, "volume of the text")
    bpy.data.objects.remove(lines)
    bend(lattice)
    draw_lattice(lattice)
    yield Tile("all bent; the text keeps its volume", text.name, whole, whole, "volume of the text")


def row(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The four objects side by side."""
    set_stage(scene)
    objects = [make((place, 0.0, 0.0)) for make, place in zip(MAKERS, PLACES)]
    set_view(scene, VIEW)
    return objects


def wrapped(objects: list[bpy.types.Object]) -> bpy.types.Object:
    """Gives all of them one lattice; returns it."""
    bpy.ops.object.select_all(action="DESELECT")
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
    if bpy.ops.isochor.add(resolution=RESOLUTION, fit="WORLD") != {"FINISHED"}:
        raise DemoError("isochor.add did not finish: see its message above")
    bpy.context.view_layer.update()
    return get_input(find_volume_lattice(objects[0]), "Lattice")


def bend(lattice: bpy.types.Object) -> None:
    """Bends the row over a hill."""
    wide, tall = lattice.scale.x, lattice.scale.z
    radius, lowest = wide / ARC, cos(ARC / 2.0)
    for point in lattice.data.points:
        x, y, z = point.co
        angle, away = ARC * x, radius + (z + 0.5) * tall
        point.co_deform = (away * sin(angle) / wide, y, (away * cos(angle) - radius * lowest) / tall - 0.5)
    bpy.context.view_layer.update()


def text_volume(text: bpy.types.Object) -> float:
    """Of what Blender draws, in the text's own space."""
    seen: Any = text.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return enclosed_volume(*drawn_arrays(seen))
