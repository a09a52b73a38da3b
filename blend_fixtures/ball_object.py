# SPDX-License-Identifier: GPL-3.0-or-later
"""The ball as a Blender object (bpy): a closed, triangulated, consistently wound mesh with its colour attributes."""

import bmesh
import bpy
import numpy as np
from ball_surface import make_ball_surface
from numpy.typing import NDArray
from stage import make_ball_material

SUBDIVISIONS = 7  # an icosphere with 10 * 4^6 + 2 = 40,962 vertices
COLOUR_ATTRIBUTES = ("latitude", "ink", "dimple", "groove")


def make_ball() -> bpy.types.Object:
    """Object "Ball" of radius 1 about its origin, linked to no collection yet."""
    mesh = _make_icosphere("Ball")
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions)
    directions = positions.reshape(-1, 3).astype(np.float64)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    surface = make_ball_surface(directions)
    shaped = (directions * surface.radius[:, None]).astype(np.float32)
    mesh.attributes["position"].data.foreach_set("vector", shaped.ravel())
    for name in COLOUR_ATTRIBUTES:
        attribute = mesh.attributes.new(name, "FLOAT", "POINT")
        attribute.data.foreach_set("value", _rounded(getattr(surface, name)))
    mesh.shade_smooth()
    mesh.materials.append(make_ball_material())
    return bpy.data.objects.new("Ball", mesh)


def _make_icosphere(name: str) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    builder = bmesh.new()
    try:
        bmesh.ops.create_icosphere(builder, subdivisions=SUBDIVISIONS, radius=1.0)
        builder.to_mesh(mesh)
    finally:
        builder.free()
    return mesh


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Colour distances to 1/4096 radian: finer than a pixel, and the file packs small."""
    return (np.round(values * 4096) / 4096).astype(np.float32)
