# SPDX-License-Identifier: GPL-3.0-or-later
"""A model of Bezier patches as a Blender surface of NURBS patches that end at their control points (bpy)."""

from typing import Any

import bpy
import numpy as np
from models.patch_model import PatchModel

ORDER = 4


def patch_surface(name: str, model: PatchModel, resolution: int = 4) -> bpy.types.Object:
    """SURFACE object in the scene with one spline of 4 x 4 points and order 4 for each patch; Blender draws each with
    4 ``resolution`` - 1 steps each way. Neighbours have the same points on their common edge, so nothing gapes."""
    surface = bpy.data.objects.new(name, bpy.data.curves.new(name, "SURFACE"))
    bpy.context.scene.collection.objects.link(surface)
    bpy.context.view_layer.objects.active = surface
    bpy.ops.object.mode_set(mode="EDIT")
    for _ in model.patches:  # Blender's Python can make a surface of several rows in no other way
        bpy.ops.surface.primitive_nurbs_surface_surface_add()
    bpy.ops.object.mode_set(mode="OBJECT")
    for spline, patch in zip(surface.data.splines, model.patches):
        _set_spline(spline, model.points[patch.T], resolution)  # Blender's surfaces look to v x u
    surface.data.update_tag()
    bpy.context.view_layer.update()
    return surface


def _set_spline(spline: Any, control: Any, resolution: int) -> None:
    places = np.concatenate([control.reshape(-1, 3), np.ones((16, 1))], axis=1)
    spline.points.foreach_set("co", places.astype(np.float32).reshape(-1))
    for axis in "uv":
        setattr(spline, f"order_{axis}", ORDER)
        setattr(spline, f"use_endpoint_{axis}", True)
        setattr(spline, f"resolution_{axis}", resolution)
    spline.use_smooth = True
