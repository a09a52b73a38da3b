# SPDX-License-Identifier: GPL-3.0-or-later
"""A shot with Blender's own Lattice modifier: as it was, converted with nothing changed, and with the volume then."""

from collections.abc import Iterator

import bpy
import numpy as np
from blender_session import DemoError
from figure import Array
from figure_stage import View, set_view
from gallery_scene import draw_lattice, evaluated_points
from gallery_tile import Tile
from models.goblin import make_goblin
from models.materials import goblin_material
from models.model_object import model_object
from stage import set_stage
from surface_measures import enclosed_volume, mesh_arrays
from volume_lattice import find_volume_lattice, set_input

NAME = "converted"
COLUMNS = 3
RESOLUTION = (4, 3, 5)
KINDS = ("KEY_CARDINAL", "KEY_LINEAR", "KEY_BSPLINE")
"""Interpolation along each of the lattice's axes."""
VIEW = View(turn=24.0, rise=12.0, height=1.0, distance=10.2, size=(520, 420))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Before, after, and with volume."""
    goblin, lattice = native_scene(scene)
    set_view(scene, VIEW)
    whole = enclosed_volume(*mesh_arrays(goblin.data))
    draw_lattice(lattice)
    before = evaluated_points(goblin)
    yield Tile("Blender's own Lattice modifier", goblin.name, whole, None)
    convert(goblin)
    apart = difference(evaluated_points(goblin), before)
    yield Tile("converted to a Volume Lattice", goblin.name, whole, None, f"differs by {apart:.0e} of its size")
    set_input(find_volume_lattice(goblin), "Preserve", 1.0)
    bpy.context.view_layer.update()
    yield Tile("then with Preserve 1", goblin.name, whole, whole)


def native_scene(scene: bpy.types.Scene) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A goblin's head, squashed by a lattice of Blender's, and that lattice."""
    set_stage(scene)
    goblin = model_object("Goblin", make_goblin(), goblin_material())
    lattice = squashing_lattice(goblin)
    for obj in (goblin, lattice):
        scene.collection.objects.link(obj)
    modifier = goblin.modifiers.new("Lattice", "LATTICE")
    modifier.object = lattice
    bpy.context.view_layer.update()
    return goblin, lattice


def squashing_lattice(obj: bpy.types.Object) -> bpy.types.Object:
    """A lattice around the object, of three kinds of interpolation, pressed flat on top and puffed out at a side."""
    data = bpy.data.lattices.new("Lattice")
    data.points_u, data.points_v, data.points_w = RESOLUTION
    for axis, kind in zip("uvw", KINDS):
        setattr(data, f"interpolation_type_{axis}", kind)
    lattice = bpy.data.objects.new("Lattice", data)
    points = mesh_arrays(obj.data)[0]
    lattice.location = (points.max(axis=0) + points.min(axis=0)) / 2.0
    # A resolution set by a script leaves Blender's grid as large as its steps were: brought back to the unit cube.
    grid = np.array([point.co for point in data.points])
    wide = np.ptp(grid, axis=0)
    lattice.scale = 1.02 * np.ptp(points, axis=0) / wide
    for point in data.points:
        x, y, z = np.array(point.co) / wide
        up = z + 0.5
        point.co_deform = (x * (1.0 - 0.1 * up) + 0.16 * up**2, y * (1.0 - 0.15 * up), up * (0.7 - 0.35 * x) - 0.5)
        point.co_deform = wide * point.co_deform
    return lattice


def convert(obj: bpy.types.Object) -> None:
    """Has the extension replace the object's native Lattice modifiers."""
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    if bpy.ops.isochor.convert() != {"FINISHED"}:
        raise DemoError("isochor.convert did not finish: see its message above")
    bpy.context.view_layer.update()


def difference(one: Array, other: Array) -> float:
    """Largest distance of two shapes along an axis, in sizes of the second."""
    return float(np.abs(one - other).max() / np.ptp(other, axis=0).max())
