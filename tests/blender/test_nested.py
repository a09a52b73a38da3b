# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices that deform lattices: Blender's own modifiers on a Lattice object that shapes a Volume Lattice."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
import tie_scenes

BEND = 0.9
"""Angle of the arc into which the outer lattice bends its height."""


def bent(points: np.ndarray) -> np.ndarray:
    """Positions over the unit cube, bent about y over their height."""
    angle = BEND * (points[:, 2] + 0.5)
    across = 1.0 / BEND - points[:, 0]
    return np.stack([1.0 / BEND - across * np.cos(angle), points[:, 1], across * np.sin(angle) - 0.5], axis=-1)


def shape(lattice: bpy.types.Object, amount: float) -> None:
    rest = np.array([tuple(point.co) for point in lattice.data.points])
    moved = (1.0 - amount) * rest + amount * bent(rest)
    lattice.data.points.foreach_set("co_deform", moved.astype(np.float32).reshape(-1))
    lattice.data.update_tag()
    bpy.context.view_layer.update()


def arm() -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.Object]:
    """A long ball, a lattice around it to bend, and a small one on its side that bulges."""
    ball = scenes.sphere()
    ball.scale = (0.5, 0.5, 1.0)
    bend = scenes.lattice_object((2, 2, 6), "Bend", 1.0)
    bend.scale = (1.6, 1.6, 2.4)
    muscle = scenes.lattice_object(4, "Muscle", 1.0)
    muscle.scale = (0.8, 0.8, 1.2)
    muscle.location = (0.35, 0.0, 0.1)
    bpy.context.view_layer.update()
    return ball, bend, muscle


def bulge(lattice: bpy.types.Object, amount: float) -> None:
    """Pushes the points inside of the block outwards, so that its faces hold still."""
    for point in lattice.data.points:
        if max(map(abs, point.co)) < 0.4:
            point.co_deform.x += amount
    lattice.data.update_tag()
    bpy.context.view_layer.update()


def evaluated_points(lattice: bpy.types.Object) -> np.ndarray:
    data = lattice.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    found = np.empty(len(data.points) * 3, np.float32)
    data.points.foreach_get("co_deform", found)
    return found.reshape(-1, 3).astype(np.float64)


def error(obj: bpy.types.Object) -> float:
    return abs(scenes.evaluated_volume(obj) / scenes.volume(obj.data) - 1.0)


def test_lattice_that_another_deforms_arrives_evaluated():
    ball, bend, _muscle = arm()
    inner = scenes.lattice_object((4, 4, 6), "Inner", 1.0)
    inner.scale = (1.2, 1.2, 2.2)
    scenes.native_lattice(inner, bend)
    modifier = scenes.volume_lattice(ball, inner, Preserve=0.0)
    own = np.array([tuple(point.co_deform) for point in inner.data.points])
    for amount in (0.5, 1.0):
        shape(bend, amount)
        assert np.abs(evaluated_points(inner) - own).max() > 0.05
        wanted = lattice_oracle.deformed(ball, inner, scenes.positions(ball.data), "Bernstein")
        assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 3e-6
    scenes.set_input(modifier, "Preserve", 1.0)
    shape(bend, 0.8)
    assert error(ball) <= 1e-6


def test_muscle_bulges_on_the_bone_that_bends_and_the_volume_is_kept():
    """The bulge comes first, in the rest pose, then the bend that carries it along."""
    ball, bend, muscle = arm()
    first = scenes.volume_lattice(ball, muscle)
    last = scenes.volume_lattice(ball, bend, Axes=(1.0, 1.0, 0.0), Space="Lattice")
    assert [scenes.get_input(found, "Preserve") for found in (first, last)] == [0.0, 1.0]
    bulge(muscle, 0.2)
    shape(bend, 1.0)
    assert error(ball) <= 1e-6
    scenes.set_input(last, "Preserve", 0.0)
    bpy.context.view_layer.update()
    bulged = lattice_oracle.deformed(ball, muscle, scenes.positions(ball.data), "Bernstein")
    assert np.abs(bulged - scenes.positions(ball.data)).max() > 0.05
    wanted = lattice_oracle.deformed(ball, bend, bulged, "Bernstein")
    assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 5e-6


def test_muscle_nested_in_the_bend_carries_both():
    """One Volume Lattice, whose lattice the animator bulges and another lattice bends, animated together."""
    ball, bend, _muscle = arm()
    muscle = scenes.lattice_object((5, 5, 5), "Nested", 1.0)
    muscle.scale = (1.3, 1.3, 2.3)
    bend.shape_key_add(name="Basis")
    key = bend.shape_key_add(name="Bend")
    rest = np.array([tuple(point.co) for point in bend.data.points])
    key.data.foreach_set("co", bent(rest).astype(np.float32).reshape(-1))
    for frame, value in ((1, 0.0), (10, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    scenes.native_lattice(muscle, bend)
    scenes.volume_lattice(ball, muscle)
    bulge(muscle, 0.15)
    straight = None
    for frame in (1, 5, 10):
        bpy.context.scene.frame_set(frame)
        assert error(ball) <= 1e-6
        straight = scenes.evaluated_positions(ball) if straight is None else straight
    assert np.abs(scenes.evaluated_positions(ball) - straight).max() > 0.3


@pytest.mark.parametrize("kind", ["HOOK", "ARMATURE"])
def test_hooks_and_bones_move_the_lattice(kind):
    ball, _bend, _muscle = arm()
    lattice = scenes.lattice_object(4, "Rigged", 2.6)
    group = lattice.vertex_groups.new(name="Upper")
    group.add([index for index, point in enumerate(lattice.data.points) if point.co.z > 0.4], 1.0, "REPLACE")
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    before = scenes.evaluated_positions(ball)
    if kind == "HOOK":
        empty = scenes.linked(bpy.data.objects.new("Empty", None))
        hook = lattice.modifiers.new("Hook", "HOOK")
        hook.object, hook.vertex_group = empty, "Upper"
        empty.location = (0.5, 0.0, -0.4)
    else:
        rig = scenes.linked(bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("Upper")
        bone.head, bone.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        lattice.modifiers.new("Armature", "ARMATURE").object = rig
        rig.pose.bones["Upper"].location = (0.5, -0.4, 0.0)
    bpy.context.view_layer.update()
    wanted = lattice_oracle.deformed(ball, lattice, scenes.positions(ball.data), "Bernstein")
    now = scenes.evaluated_positions(ball)
    assert np.abs(now - wanted).max() < 3e-6
    assert np.abs(now - before).max() > 0.05


def test_tied_blocks_that_one_lattice_deforms_stay_tied():
    obj, blocks, _modifiers = tie_scenes.tied_bar("C0")
    bend = scenes.lattice_object((6, 2, 2), "Bend", 1.0)
    bend.scale = (4.4, 2.0, 2.0)
    for lattice in blocks:
        scenes.native_lattice(lattice, bend)
    bpy.context.view_layer.update()
    for point in bend.data.points:
        point.co_deform.z += 0.8 * point.co.x**2
    bend.data.update_tag()
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for number in (1, 2):
        jump, moved = tie_scenes.joint(obj, number, depsgraph)
        assert moved > 0.01
        assert jump < 0.5
    assert tie_scenes.error(obj) <= 1e-6
