# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that are no meshes, in a row: lettering, a coil, a tuft of hair, a cloud of points (bpy)."""

from math import pi, radians

import bpy
import numpy as np
from stage import CORAL, CREAM, TEAL, Triple, tint

from .materials import GOLD


def make_text(place: Triple) -> bpy.types.Object:
    """Standing letters, thick."""
    data = bpy.data.curves.new("Text", "FONT")
    data.body, data.size, data.extrude, data.align_x = "FFD", 1.3, 0.14, "CENTER"
    data.resolution_u = 24
    return _placed("Text", data, place, CORAL, radians(90.0))


def make_coil(place: Triple) -> bpy.types.Object:
    """A curve with a round section, wound up."""
    data = bpy.data.curves.new("Coil", "CURVE")
    data.dimensions, data.bevel_depth, data.bevel_resolution, data.use_fill_caps = "3D", 0.075, 6, True
    angle = np.linspace(0.0, 10.0 * pi, 161)
    spline = data.splines.new("POLY")
    spline.points.add(len(angle) - 1)
    height = 0.08 + 1.25 * angle / angle[-1]
    way = np.stack([0.42 * np.cos(angle), 0.42 * np.sin(angle), height, np.ones(len(angle))], axis=1)
    spline.points.foreach_set("co", way.astype(np.float32).ravel())
    return _placed("Coil", data, place, TEAL)


def make_hair(place: Triple) -> bpy.types.Object:
    """Blades that grow from the ground, as curves of the kind that Blender's hair is."""
    strands, points = 700, 8
    random = np.random.default_rng(5)
    away, angle = 0.5 * np.sqrt(random.random(strands)), 2.0 * pi * random.random(strands)
    root = np.stack([away * np.cos(angle), away * np.sin(angle), 0.0 * away], axis=1)
    up = np.linspace(0.0, 1.0, points)[None, :, None]
    tip = root * (0.5, 0.5, 0.0) + np.stack([0.0 * away, 0.0 * away, 1.35 - 0.7 * away], axis=1)
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([points] * strands)
    places = root[:, None] + up * (tip * (0.6, 0.6, 1.0))[:, None]
    data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(np.linspace(0.016, 0.004, points), strands).astype(np.float32))
    return _placed("Hair", data, place, GOLD)


def make_cloud(place: Triple) -> bpy.types.Object:
    """A ball of points, each shown as a bead."""
    count = 260
    height = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    angle = np.arange(count) * pi * (3.0 - 5.0**0.5)
    wide = np.sqrt(1.0 - height**2)
    places = 0.55 * np.stack([wide * np.cos(angle), wide * np.sin(angle), height], axis=1) + (0.0, 0.0, 0.68)
    data = bpy.data.pointclouds.new("Cloud")
    data.resize(count)
    data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.full(count, 0.055, np.float32))
    return _placed("Cloud", data, place, CREAM)


def _placed(name: str, data: bpy.types.ID, place: Triple, colour: Triple, lean: float = 0.0) -> bpy.types.Object:
    data.materials.append(tint(name, colour))
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.rotation_euler.x = place, lean
    bpy.context.scene.collection.objects.link(obj)
    return obj
