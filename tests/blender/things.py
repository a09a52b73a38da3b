# SPDX-License-Identifier: GPL-3.0-or-later
"""Small objects of every kind that is made of points, and what Blender shows of them."""

from typing import Any

import bpy
import numpy as np
import scenes
from numpy.typing import NDArray

Points = NDArray[np.float64]


def curve(kind: str, points: Any, name: str = "Curve", cyclic: bool = False) -> bpy.types.Object:
    """A curve object with one spline: kind BEZIER (with free handles, none in line with its point), NURBS or POLY."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    add_spline(data, kind, points, cyclic)
    return scenes.linked(bpy.data.objects.new(name, data))


def add_spline(data: bpy.types.Curve, kind: str, points: Any, cyclic: bool = False) -> bpy.types.Spline:
    spline = data.splines.new(kind)
    spline.use_cyclic_u = cyclic
    made = spline.bezier_points if kind == "BEZIER" else spline.points
    made.add(len(points) - len(made))
    for index, (point, place) in enumerate(zip(made, points, strict=True)):
        if kind == "BEZIER":
            point.handle_left_type = point.handle_right_type = "FREE"
            point.co = place
            point.handle_left = np.add(place, (-0.2, 0.1 * index, 0.05))
            point.handle_right = np.add(place, (0.25, -0.05, 0.1))
        else:
            point.co = (*place, 1.0 + 0.5 * (index % 2))
    return spline


def path(count: int = 6) -> Points:
    """Points along a crooked way within the cube of side 2 about the origin."""
    place = np.linspace(-1.0, 1.0, count)
    return np.stack([0.9 * place, 0.6 * np.sin(3.0 * place), 0.5 * np.cos(2.0 * place)], axis=1)


def hair(strands: int = 5, points: int = 4) -> bpy.types.Object:
    """Hair curves that grow from a ring."""
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([points] * strands)
    angle = 2.0 * np.pi * np.arange(strands) / strands
    root = np.stack([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0.0 * angle], axis=1)
    height = np.linspace(0.0, 0.8, points)
    places = root[:, None, :] * (1.0 + 0.3 * height[None, :, None] ** 2)
    places[..., 2] = height
    data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    return scenes.linked(bpy.data.objects.new("Hair", data))


def cloud(count: int = 40) -> bpy.types.Object:
    """A point cloud."""
    places = np.random.default_rng(3).uniform(-0.9, 0.9, (count, 3))
    if hasattr(bpy.types.PointCloud, "resize"):
        data = bpy.data.pointclouds.new("Cloud")
        data.resize(count)
        data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
        return scenes.linked(bpy.data.objects.new("Cloud", data))
    # Before Blender 5 only a mesh can become one.
    obj = scenes.mesh_object("Cloud", places, [])
    bpy.ops.object.convert(target="POINTCLOUD")
    return obj


def text(body: str = "Iso", extrude: float = 0.1) -> bpy.types.Object:
    """A text object."""
    data = bpy.data.curves.new("Text", "FONT")
    data.body, data.extrude = body, extrude
    return scenes.linked(bpy.data.objects.new("Text", data))


def shown(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> dict[str, Points]:
    """Positions of the points of each kind that Blender shows, and handles, by name; in object space."""
    geometry = obj.evaluated_get(depsgraph or bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    found = {}
    for name in ("mesh", "curves", "pointcloud"):
        data = getattr(geometry, name)
        for attribute in ("position", "handle_left", "handle_right"):
            if data is not None and attribute in data.attributes and len(data.attributes[attribute].data):
                key = name if attribute == "position" else attribute
                found[key] = vectors(data, attribute)
    return found


def vectors(data: Any, name: str) -> Points:
    """(V, 3) of an attribute."""
    values = data.attributes[name].data
    flat = np.empty(len(values) * 3, np.float32)
    values.foreach_get("vector", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def numbers(data: Any, name: str) -> NDArray[np.float64]:
    """(V,) of an attribute."""
    return np.array([one.value for one in data.attributes[name].data], np.float64)


def attribute(obj: bpy.types.Object, name: str, values: Any) -> None:
    """Gives hair or a point cloud a number a point."""
    made = obj.data.attributes.new(name, "FLOAT", "POINT")
    made.data.foreach_set("value", np.asarray(values, np.float32))
