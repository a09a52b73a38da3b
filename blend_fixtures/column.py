# SPDX-License-Identifier: GPL-3.0-or-later
"""A rounded column, closed and triangulated, whose stripes show how space bends, twists and squashes (bpy)."""

import bpy
import numpy as np
from numpy.typing import NDArray
from rings import ring_triangles
from stage import make_striped_material

SIDES, RINGS, CAP_RINGS = 96, 96, 14
HALF_WIDTH, HEIGHT = 0.5, 2.4
SQUARENESS = 5.0
"""Exponent of the superellipse: 2 is round, large is square."""
STRIPES_UP, STRIPES_AROUND = 12, 8


def make_column(name: str = "Column") -> bpy.types.Object:
    """Object that stands on its origin, linked to no collection yet."""
    points, around, up = _surface()
    mesh = bpy.data.meshes.new(name)
    triangles = ring_triangles(len(points), SIDES)
    mesh.vertices.add(len(points))
    mesh.attributes["position"].data.foreach_set("vector", points.astype(np.float32).reshape(-1))
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.reshape(-1))
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    for name_of_attribute, values in (("around", around), ("up", up)):
        attribute = mesh.attributes.new(name_of_attribute, "FLOAT", "POINT")
        attribute.data.foreach_set("value", values.astype(np.float32))
    mesh.shade_smooth()
    mesh.materials.append(make_striped_material())
    return bpy.data.objects.new(name, mesh)


def _surface() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Points (V, 3), and the waves (V,) around and up whose sign tells one stripe from the next.

    Rings from the bottom's middle to the top's; the first and the last point are those middles.
    """
    cap = np.arange(1, CAP_RINGS) / CAP_RINGS
    shares = np.concatenate([cap, np.ones(RINGS), cap[::-1]])
    rise = np.concatenate([np.zeros(CAP_RINGS - 1), np.linspace(0.0, 1.0, RINGS), np.ones(CAP_RINGS - 1)])
    angle = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outline /= ((np.abs(outline) ** SQUARENESS).sum(axis=1) ** (1.0 / SQUARENESS))[:, None]
    rounded = 1.0 - 0.06 * np.exp(-((np.minimum(rise, 1.0 - rise) * 28.0) ** 2))
    ring = outline[None] * (HALF_WIDTH * shares * rounded)[:, None, None]
    height = np.repeat((HEIGHT * rise)[:, None], SIDES, axis=1)
    points = np.concatenate([ring, height[..., None]], axis=-1).reshape(-1, 3)
    ends = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, HEIGHT]])
    around = np.tile(np.sin(angle * STRIPES_AROUND / 2.0), len(shares))
    up = np.repeat(np.sin(np.pi * rise * STRIPES_UP), SIDES)
    return np.concatenate([points, ends]), np.append(around, [0.0, 0.0]), np.append(up, [0.0, 0.0])
