# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes to take pictures of."""

from collections.abc import Callable
from math import cos, pi, sin

import bpy

Point = tuple[float, float, float]

RED, SAND = (0.80, 0.24, 0.16, 1.0), (0.85, 0.62, 0.36, 1.0)


def clear() -> None:
    """Takes everything out of the file's scene."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.context.scene.frame_set(1)


def with_lattice(obj: bpy.types.Object, colour: tuple[float, float, float, float], resolution: Point) -> None:
    """Smooths and colours the object and adds a Volume Lattice."""
    obj.color = colour
    bpy.ops.object.shade_smooth()
    bpy.ops.isochor.add(resolution=resolution)


def ball() -> bpy.types.Object:
    """A triangulated ball of radius 1 with a lattice of 4 x 4 x 4 points."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1.0)
    obj = bpy.context.object
    obj.name = "Ball"
    with_lattice(obj, RED, (4, 4, 4))
    return obj


def column() -> bpy.types.Object:
    """A square column with rounded edges, and a lattice of 4 x 4 x 6 points."""
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    obj = bpy.context.object
    obj.name = "Column"
    obj.scale = (1.3, 1.3, 3.4)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bevel(offset=0.12, segments=4, affect="EDGES")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=12)
    bpy.ops.mesh.quads_convert_to_tris()
    bpy.ops.object.mode_set(mode="OBJECT")
    with_lattice(obj, SAND, (4, 4, 6))
    return obj


def lattice_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The lattice that isochor.add made for the object."""
    return bpy.data.objects[f"{obj.name} Lattice"]


def shape(lattice: bpy.types.Object, bend: Callable[[Point], Point]) -> None:
    """Moves the lattice's points; ``bend`` maps places in lattice space, where the box is the unit cube."""
    for point in lattice.data.points:
        point.co_deform = bend(tuple(point.co_deform))
    bpy.context.view_layer.update()


def squash(place: Point) -> Point:
    """Half as high, leaning a little."""
    x, y, z = place
    return x + 0.12 * z, y, 0.5 * z - 0.08 * x


def push_through(place: Point) -> Point:
    """The top of one side pulled down through the bottom."""
    x, y, z = place
    return (x, y, -1.2) if z > 0.4 and x > 0.1 else place


def twist_and_lean(place: Point) -> Point:
    """A third of a turn from foot to top, with a bow to one side."""
    x, y, z = place
    turn = 2.0 * pi / 3.0 * (z + 0.5)
    bow = 1.1 * (z + 0.5) ** 2
    return x * cos(turn) - y * sin(turn) + bow, x * sin(turn) + y * cos(turn), z - 0.06 * bow


def animate_squash(lattice: bpy.types.Object) -> None:
    """A shape key that squashes, keyed over 48 frames as a bounce."""
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash")
    for point in key.data:
        x, y, z = point.co
        point.co = (x, y, 0.36 * z)
    for frame, value in ((1, 0.0), (7, 0.0), (13, 1.0), (20, -0.25), (29, 0.0), (35, 0.7), (41, -0.12), (48, 0.0)):
        key.slider_min = -1.0
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 48
