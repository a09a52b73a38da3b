# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice that is shaped first and bound then: its shape moves nothing, what is done afterwards does."""

from collections.abc import Iterator

import bpy
from blender_session import DemoError
from column import make_column
from gallery_scene import Staged, draw_lattice
from gallery_tile import Tile
from mathutils import Matrix, Vector

NAME = "binding"
LEAN = Matrix.Shear("XY", 4, (0.45, 0.0))
"""Of space: x grows with z."""


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """A leaning column, and a lattice that was leant to fit it before the column was bound."""
    column = make_column()
    column.scale = (0.8, 0.8, 0.8)
    column.location.x = -0.5
    staged = Staged(scene, column, (3, 3, 4), basis="BERNSTEIN")
    staged.put(Outside="Extend")
    column.data.transform(LEAN)
    straight = [staged.lattice.matrix_world @ point.co_deform for point in staged.lattice.data.points]
    put_points(staged.lattice, [leant(column, place) for place in straight])
    yield from drawn(staged, "the lattice leant, not bound")
    if bpy.ops.isochor.set_rest() != {"FINISHED"}:
        raise DemoError("isochor.set_rest did not finish: see its message above")
    yield from drawn(staged, "Set Rest: its shape moves nothing")
    lower = [leant(column, Vector((place.x, place.y, 0.55 * place.z))) for place in straight]
    put_points(staged.lattice, lower)
    yield from drawn(staged, "then squashed along the lean")


def leant(column: bpy.types.Object, place: Vector) -> Vector:
    """Where the lean takes a place in the world."""
    return column.matrix_world @ LEAN @ column.matrix_world.inverted() @ place


def put_points(lattice: bpy.types.Object, places: list[Vector]) -> None:
    """Puts the lattice's points at these places in the world."""
    inverse = lattice.matrix_world.inverted()
    for point, place in zip(lattice.data.points, places):
        point.co_deform = inverse @ place
    bpy.context.view_layer.update()


def drawn(staged: Staged, caption: str) -> Iterator[Tile]:
    """One picture with the lattice in it."""
    lines = draw_lattice(staged.lattice)
    yield staged.tile(caption)
    bpy.data.objects.remove(lines)
