# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive tessellation: a beam of ten faces bent, applied as it is, divided where it bends, and divided everywhere."""

from collections.abc import Iterator

import bpy
import numpy as np
from blender_session import DemoError
from figure_lattice import turned
from figure_stage import View, set_view
from gallery_scene import Staged, clear_stage, draw_paths
from gallery_tile import Tile
from mathutils import Vector
from models.beam import TALL, divided, make_beam
from stage import CORAL, TEAL, tint

NAME = "adaptive"
COLUMNS = 3
TOLERANCE = 0.01
"""How far faces and edges may be from the bent space, in scene units."""
LAYERS = 7
BEND = 1.9
"""Angle of the bend, in radians."""
EVEN = 8
"""Parts of each edge that keep the same tolerance where the beam bends most."""
VIEW = View(turn=-22.0, rise=12.0, height=1.15, distance=8.0, size=(520, 420))
EDGE = 0.006
"""Radius of the drawn edges, in scene units."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Bent as it is, adaptively divided, evenly divided."""
    yield shown(bent(scene), "ten faces, bent")
    staged = bent(scene)
    apply(staged.object, TOLERANCE)
    yield shown(staged, f"applied with Tolerance {TOLERANCE}")
    yield shown(bent(scene, EVEN), "divided everywhere as finely")


def bent(scene: bpy.types.Scene, parts: int = 1) -> Staged:
    """The beam, its upper half bent over."""
    clear_stage()
    staged = Staged(scene, beam_object(parts), (2, 2, LAYERS), margin=0.0)
    set_view(scene, VIEW)
    lattice = staged.lattice
    to_own = lattice.matrix_world.inverted()
    for point in lattice.data.points:
        place = np.array(lattice.matrix_world @ point.co)
        height = max(place[2] - TALL / 2.0, 0.0)
        angle = BEND * height / (TALL / 2.0)
        radius = TALL / 2.0 / BEND
        if height > 0.0:
            x, z = turned(place[0] - radius, 0.0, -angle)
            place[0], place[2] = x + radius, z + TALL / 2.0
        point.co_deform = to_own @ Vector(place)
    bpy.context.view_layer.update()
    return staged


def beam_object(parts: int) -> bpy.types.Object:
    """The beam, its lower half of one colour and its upper of another, every edge in so many parts."""
    points, quads = divided(*make_beam(), parts)
    mesh = bpy.data.meshes.new("Beam")
    mesh.from_pydata(points.tolist(), [], quads)
    for colour in (TEAL, CORAL):
        mesh.materials.append(tint("Beam", colour))
    for polygon in mesh.polygons:
        polygon.material_index = int(polygon.center.z > TALL / 2.0)
    return bpy.data.objects.new("Beam", mesh)


def apply(obj: bpy.types.Object, tolerance: float) -> None:
    """Applies the object's Volume Lattice with that tolerance."""
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    if bpy.ops.isochor.apply(tolerance=tolerance) != {"FINISHED"}:
        raise DemoError("isochor.apply did not finish: see its message above")
    bpy.context.view_layer.update()


def shown(staged: Staged, caption: str) -> Tile:
    """The picture of it with its edges drawn, and how many faces it has."""
    seen = staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh, matrix = seen.data, staged.object.matrix_world
    draw_paths("Edges", [[matrix @ mesh.vertices[end].co for end in edge.vertices] for edge in mesh.edges], EDGE)
    return Tile(caption, staged.object.name, staged.whole, staged.whole, f"{len(mesh.polygons)} faces")
