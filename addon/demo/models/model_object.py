# SPDX-License-Identifier: GPL-3.0-or-later
"""A model as a Blender object (bpy)."""

import bpy
import numpy as np

from .model import Model


def model_object(name: str, model: Model, material: bpy.types.Material) -> bpy.types.Object:
    """Object with the model's triangles and its values as attributes, shaded smooth, linked to no collection yet."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(model.points))
    mesh.attributes["position"].data.foreach_set("vector", model.points.astype(np.float32).reshape(-1))
    mesh.loops.add(model.triangles.size)
    mesh.loops.foreach_set("vertex_index", model.triangles.reshape(-1))
    mesh.polygons.add(len(model.triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, model.triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    for title, values in model.values.items():
        attribute = mesh.attributes.new(title, "FLOAT", "POINT")
        attribute.data.foreach_set("value", values.astype(np.float32))
    mesh.shade_smooth()
    mesh.materials.append(material)
    return bpy.data.objects.new(name, mesh)
