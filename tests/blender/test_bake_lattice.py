# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to Blender's own Lattice modifier: without the add-on every frame has the very same shape and volume."""

import bpy
import elsewhere
import numpy as np
import pytest
import scenes

FRAMES = 7
EXACT = [
    ("Bernstein", (4, 4, 4)),
    ("Bernstein", (2, 2, 2)),
    ("Bernstein", (3, 4, 2)),
    ("Bernstein", (1, 3, 3)),
    ("B-Spline", (6, 5, 4)),
    ("B-Spline", (3, 2, 7)),
    ("B-Spline", (5, 1, 4)),
]


def cage(basis: str, shape: tuple[int, int, int], name: str = "Cage") -> bpy.types.Object:
    """A lattice whose domain holds the ball with room to spare, squashed, sheared and swung by a keyed shape key."""
    lattice = scenes.lattice_object(shape, name=name)
    for axis, points in enumerate(shape):
        degree = max(1, min(3, points - 1)) if basis == "B-Spline" else 1
        lattice.scale[axis] = 3.2 * (points - 1) / (points - degree if basis == "B-Spline" else points - 1) if points > 1 else 3.2
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash", from_mix=False)
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.3 * z + 0.1, y + 0.15 * x * z, 0.5 * z + 0.1 * x * y)
    for frame, value in ((1, 0.0), (FRAMES // 2, 1.0), (FRAMES, 0.3)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return lattice


def move(obj: bpy.types.Object, far: float) -> None:
    """Keys a small journey with a turn."""
    for frame, place in ((1, 0.0), (FRAMES, far)):
        obj.location, obj.rotation_euler = (place, -place, 0.5 * place), (0.2 * place, 0.3 * place, 0.9 * place)
        obj.keyframe_insert("location", frame=frame)
        obj.keyframe_insert("rotation_euler", frame=frame)


def scene(basis: str, shape: tuple[int, int, int], moving: str = "") -> tuple[bpy.types.Object, bpy.types.Object]:
    """The ball and its lattice: of them stands, or moves, what ``moving`` says: "", "both" or "object"."""
    ball = scenes.sphere(20, 12)
    lattice = cage(basis, shape)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    ball.scale = (1.0, 1.2, 0.8)
    lattice.scale = [one * other for one, other in zip(lattice.scale, (1.0, 1.2, 0.8), strict=True)]
    lattice.rotation_euler = (0.1, 0.0, 0.15)
    if moving == "both":
        bpy.context.view_layer.update()
        lattice.parent = ball
        lattice.matrix_parent_inverse = ball.matrix_world.inverted()
        move(ball, 2.0)
    if moving == "object":
        move(ball, 0.15)
    bpy.context.scene.frame_set(1)
    scenes.volume_lattice(ball, lattice, Basis=basis)
    scenes.choose(ball)
    return ball, lattice


def shapes(obj: bpy.types.Object) -> np.ndarray:
    """(frames, V, 3): what Blender draws of the object."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def bake(**settings) -> set:
    return bpy.ops.isochor.bake(format="LATTICE", **settings)


def require_same(tmp_path, ball: bpy.types.Object, before: np.ndarray, whole: float) -> None:
    """Without the add-on the shapes are these, to 1e-6 of the size, and have this volume."""
    after = elsewhere.played(tmp_path, ball.name, [float(frame) for frame in range(1, FRAMES + 1)])
    size = np.ptp(before[0], axis=0).max()
    assert np.ptp(before, axis=0).max() > 0.1 * size
    assert np.abs(after - before).max() <= 1e-6 * size
    for shape in after:
        assert abs(elsewhere.volume(shape, ball) / whole - 1) <= 1e-6


@pytest.mark.parametrize("moving", ["", "both", "object"])
@pytest.mark.parametrize(("basis", "shape"), EXACT)
def test_without_the_add_on_it_is_the_same_in_every_frame(tmp_path, basis, shape, moving):
    ball, _lattice = scene(basis, shape, moving)
    before, whole = shapes(ball), scenes.volume(ball.data)
    assert bake() == {"FINISHED"}
    ours, native = ball.modifiers
    assert (native.type, native.object.data.users) == ("LATTICE", 1)
    assert not (ours.show_viewport or ours.show_render)
    require_same(tmp_path, ball, before, whole)
