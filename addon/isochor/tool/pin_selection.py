# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a mesh that are selected, as points of the shape that a modifier makes of it."""

import bpy
import numpy as np
from numpy.typing import NDArray

from . import evaluated
from .lattices import Pair
from .pinning import Point, Shape, own_count, shape_of


def points(pair: Pair, faces: bool, depsgraph: bpy.types.Depsgraph) -> list[Point]:
    """The selected vertices, or with ``faces`` the middles of the selected faces. Raises ``Problem`` where the modifier
    computed no shape. Not for a mesh in Edit Mode, whose selection Blender keeps elsewhere."""
    obj, modifier = pair
    chosen = selected(obj, faces)
    if not len(chosen):
        return []
    shape = shape_of(obj, modifier, depsgraph)
    kept = own_count(obj, modifier) is not None or len(shape.entered) == len(obj.data.vertices)
    if faces:
        return [_middle(obj, shape, obj.data.polygons[index], kept) for index in chosen]
    if kept:
        return [shape.vertex(index) for index in chosen]
    own = evaluated.own_shape(obj.data)[0].astype(np.float64)
    return [shape.at(shape.place_at_rest(own[index])) for index in chosen]


def selected(obj: bpy.types.Object, faces: bool) -> list[int]:
    """Indices of the selected vertices or faces of an object's own mesh."""
    elements = obj.data.polygons if faces else obj.data.vertices
    flags: NDArray[np.bool_] = np.empty(len(elements), np.bool_)
    elements.foreach_get("select", flags)
    return [int(index) for index in np.flatnonzero(flags)]


def _middle(obj: bpy.types.Object, shape: Shape, face: bpy.types.MeshPolygon, kept: bool) -> Point:
    """The point nearest to the middle of the corners of a face, as it shows where its vertices are those that entered,
    else as it is in the mesh."""
    corners = list(face.vertices)
    if kept:
        middle = np.mean([shape.vertex(corner).world for corner in corners], axis=0)
        return shape.nearest(middle)
    own = evaluated.own_shape(obj.data)[0].astype(np.float64)
    return shape.at(shape.place_at_rest(own[corners].mean(axis=0)))
