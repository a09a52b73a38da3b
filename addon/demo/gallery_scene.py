# SPDX-License-Identifier: GPL-3.0-or-later
"""What the gallery's pages have in common: a stage with one object under a Volume Lattice, inputs, and the lattice
made visible (bpy)."""

import importlib
from collections.abc import Iterable
from math import radians
from typing import Any

import bpy
import numpy as np
from blender_session import EXTENSION
from column import make_column
from gallery_tile import Tile
from mathutils import Vector
from numpy.typing import NDArray
from stage import INK, Colour, set_stage, tint
from surface_measures import enclosed_volume, measure, mesh_arrays
from volume_lattice import add_volume_lattice, find_volume_lattice, get_input, input_path, menu_items, set_input

WIRE = 0.012
"""Radius of the lattice's lines, in scene units."""


class Staged:
    """One object on the stage, its lattice and its modifier."""

    def __init__(
        self, scene: bpy.types.Scene, obj: bpy.types.Object, resolution: tuple[int, int, int], **fit: Any
    ) -> None:
        """``fit``: basis, margin and fit of the lattice, where not those of ``add_volume_lattice``."""
        set_stage(scene)
        scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        self.object = obj
        self.lattice = add_volume_lattice(obj, resolution, **fit)
        self.modifier = find_volume_lattice(obj)
        self.whole = enclosed_volume(*mesh_arrays(obj.data))

    def put(self, **inputs: Any) -> None:
        """Sets inputs of the modifier by name, with _ for a space."""
        for name, value in inputs.items():
            set_input(self.modifier, name.replace("_", " "), value)
        bpy.context.view_layer.update()

    @property
    def size(self) -> float:
        """Largest extent of the mesh at rest, in the object's own space."""
        return float(np.ptp(mesh_arrays(self.object.data)[0], axis=0).max())

    def value(self, name: str) -> Any:
        """Value of an input of the modifier; of a menu the item's name."""
        found = get_input(self.modifier, name)
        return menu_items(self.modifier, name)[found] if isinstance(found, int) and self.menu(name) else found

    def menu(self, name: str) -> list[str]:
        """Items of an input that is a menu, else none."""
        return menu_items(self.modifier, name)

    def key(self, name: str, value: float, frame: int) -> None:
        """Keys an input of the modifier."""
        set_input(self.modifier, name, value)
        path = f'modifiers["{self.modifier.name}"].{input_path(self.modifier, name)}'
        self.object.keyframe_insert(path, frame=frame)

    @property
    def report(self) -> Any:
        """What the extension's sidebar would show of the frame."""
        state = importlib.import_module(f"{EXTENSION}.tool.state")
        return state.recall(self.object, self.modifier).report

    def tile(self, caption: str, promised: bool = True, note: str = "") -> Tile:
        """The stage as it stands now, the volume at rest promised or nothing."""
        return Tile(caption, self.object.name, self.whole, self.whole if promised else None, note)


def clear_stage() -> None:
    """Takes every object away."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)


def standing_column() -> bpy.types.Object:
    """The striped column, turned so that two of its sides are seen, and small enough to be stretched in the picture."""
    column = make_column()
    column.scale = (0.8, 0.8, 0.8)
    column.rotation_euler.z = radians(-28.0)
    return column


def evaluated_points(obj: bpy.types.Object) -> NDArray[np.float64]:
    """Places (V, 3) of what Blender draws of the object, in its own space."""
    seen: Any = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return mesh_arrays(seen.data)[0].astype(np.float64)


def lowest(obj: bpy.types.Object) -> float:
    """Height above the ground of the lowest vertex that is drawn."""
    evaluated: Any = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    positions, triangles = mesh_arrays(evaluated.data)
    return measure(positions, triangles, evaluated.matrix_world).lowest


def draw_lattice(lattice: bpy.types.Object, layer: int | None = None) -> bpy.types.Object:
    """An object of thin tubes along the lattice's lines as it is shaped now, for renders show none by themselves: those
    of its outer faces, or of one layer of points."""
    data: Any = lattice.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    places = np.array([lattice.matrix_world @ point.co_deform for point in data.points])
    places = places.reshape(data.points_w, data.points_v, data.points_u, 3)
    return draw_lines(f"{lattice.name} Lines", places if layer is None else places[layer : layer + 1])


def draw_lines(name: str, places: Any) -> bpy.types.Object:
    """Thin tubes between the places (n, n, n, 3) of a grid in the world, along its outer faces."""
    return draw_paths(name, _lines(np.asarray(places)))


def draw_paths(name: str, paths: Iterable[Any], radius: float = WIRE, colour: Colour = INK) -> bpy.types.Object:
    """Thin tubes along paths, each (points, 3), in the world."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", radius
    for path in paths:
        spline = curve.splines.new("POLY")
        spline.points.add(len(path) - 1)
        for point, place in zip(spline.points, path):
            point.co = (*place, 1.0)
    curve.materials.append(tint("Lattice", colour))
    drawn = bpy.data.objects.new(curve.name, curve)
    bpy.context.scene.collection.objects.link(drawn)
    return drawn


def moved_layer(lattice: bpy.types.Object, layer: int, by: Any) -> None:
    """Moves one layer of points along the lattice's last axis, by a vector in the world."""
    aside = lattice.matrix_world.to_3x3().inverted() @ Vector(by)
    count = lattice.data.points_u * lattice.data.points_v
    for point in list(lattice.data.points)[layer * count : (layer + 1) * count]:
        point.co_deform += aside
    bpy.context.view_layer.update()


def _lines(places: Any) -> list[Any]:
    """The lines, each (points, 3)."""
    found = []
    for along in range(3):
        rows = np.moveaxis(places, along, 2)
        for a, b in np.ndindex(rows.shape[:2]):
            if rows.shape[2] > 1 and (a in (0, rows.shape[0] - 1) or b in (0, rows.shape[1] - 1)):
                found.append(rows[a, b])
    return found
