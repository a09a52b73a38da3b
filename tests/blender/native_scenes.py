# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in which Blender's own Lattice modifier is the oracle."""

import bpy
import numpy as np
import scenes
from mathutils import Matrix
from numpy.typing import NDArray

TYPES = ("KEY_LINEAR", "KEY_CARDINAL", "KEY_CATMULL_ROM", "KEY_BSPLINE")
FRAMES = 6
CLOSE = 1e-6
"""Of the object's size."""


def shaken(
    shape: tuple[int, int, int], types: tuple[str, str, str], size: float = 2.4, seed: int = 3
) -> bpy.types.Object:
    """A lattice with every point moved at random, by more the fewer they are."""
    lattice = scenes.lattice_object(shape, name="Cage", size=size)
    set_types(lattice, types)
    random = np.random.default_rng(seed)
    for point in lattice.data.points:
        point.co_deform = [place + random.normal(0.0, 0.12) for place in point.co_deform]
    return lattice


def set_types(lattice: bpy.types.Object, types: tuple[str, str, str]) -> None:
    for axis, kind in zip("uvw", types, strict=True):
        setattr(lattice.data, f"interpolation_type_{axis}", kind)


def native(obj: bpy.types.Object, lattice: bpy.types.Object, **properties) -> bpy.types.LatticeModifier:
    modifier = scenes.native_lattice(obj, lattice)
    for name, value in properties.items():
        setattr(modifier, name, value)
    return modifier


def pair(lattice: bpy.types.Object, **inputs) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball with our modifier, Preserve 0, and its twin, which shares the mesh, for Blender's own."""
    ball = scenes.sphere(20, 13)
    scenes.volume_lattice(ball, lattice, Basis="Blender", Outside="Extend", Preserve=0.0, **inputs)
    twin = bpy.data.objects.new("Twin", ball.data)
    bpy.context.scene.collection.objects.link(twin)
    return ball, twin


def group(obj: bpy.types.Object, name: str = "Part", seed: int = 11) -> None:
    """A vertex group of a mesh or lattice with weights from 0 to 1, and some points outside it."""
    count = len(obj.data.points) if obj.type == "LATTICE" else len(obj.data.vertices)
    made, random = obj.vertex_groups.new(name=name), np.random.default_rng(seed)
    for index, weight in enumerate(random.random(count)):
        if weight < 0.8:
            made.add([index], float(weight), "REPLACE")


def sheared(obj: bpy.types.Object, angle: float) -> None:
    """Has a parent with an uneven scale shear the object."""
    parent = bpy.data.objects.new(f"{obj.name} Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale, parent.rotation_euler = (1.3, 0.7, 1.0), (0.2, 0.1, angle)
    obj.parent = parent
    obj.matrix_parent_inverse = Matrix.Identity(4)
    obj.rotation_euler = (angle, 0.3, -0.2)


def apart(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Largest distance of two shapes, as a fraction of the second one's size."""
    return float(np.abs(one - other).max() / np.ptp(other.reshape(-1, 3), axis=0).max())


def require_same(ball: bpy.types.Object, twin: bpy.types.Object) -> None:
    """Both show the same, and it is not their own shape."""
    bpy.context.view_layer.update()
    shown, wanted = scenes.evaluated_positions(ball), scenes.evaluated_positions(twin)
    assert apart(shown, wanted) <= CLOSE
    assert apart(wanted, scenes.positions(ball.data)) > 0.01
