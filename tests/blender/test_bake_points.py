# SPDX-License-Identifier: GPL-3.0-or-later
"""Control points baked to shape keys: the same as deformed frame by frame, without the add-on too."""

import bpy
import numpy as np
import pytest
import scenes
import things
from test_points import MAKERS, choose, everything, read
from test_points_of_all_kinds import keyed_lattice


@pytest.fixture(params=MAKERS)
def moving(request):
    """The object to deform and a lattice around it that bends over ten frames, active."""
    scenes.empty_file()
    obj = MAKERS[request.param]()
    bpy.context.view_layer.update()
    lattice = keyed_lattice()
    lattice.name = "Outer"
    choose(obj, lattice)
    return obj, lattice


def seen(obj):
    """What Blender evaluates: points of a lattice, else all that is drawn."""
    if obj.type != "LATTICE":
        return np.concatenate(list(things.shown(obj).values()))
    held = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([tuple(point.co_deform) for point in held.data.points], np.float64)


def test_every_frame_is_the_frame_deformed(moving):
    obj, lattice = moving
    scene, before = bpy.context.scene, everything(obj)
    wanted = {}
    for frame in (1, 4, 7, 10):
        scene.frame_set(frame)
        choose(obj, lattice)
        assert bpy.ops.isochor.deform_points() == {"FINISHED"}
        wanted[frame] = seen(obj)
    scene.frame_set(3)
    assert bpy.ops.isochor.bake_points("EXEC_DEFAULT", frame_start=1, frame_end=10) == {"FINISHED"}
    assert scene.frame_current == 3
    for frame, points in wanted.items():
        scene.frame_set(frame)
        assert np.abs(seen(obj) - points).max() == 0.0, frame
    assert np.abs(wanted[10] - wanted[1]).max() > 0.05
    bpy.data.objects.remove(lattice)
    scene.frame_set(1)
    scene.frame_set(7)
    assert np.abs(seen(obj) - wanted[7]).max() == 0.0
    scenes.choose(obj)
    assert bpy.ops.isochor.restore_points() == {"FINISHED"}
    assert everything(obj) == before
    assert not [action for action in bpy.data.actions if "Baked" in action.name]


def test_it_is_saved_and_baked_again(moving, tmp_path):
    obj, lattice = moving
    name = obj.name
    assert bpy.ops.isochor.bake_points(frame_start=1, frame_end=10) == {"FINISHED"}
    bpy.context.scene.frame_set(8)
    shown = seen(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "baked.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "baked.blend"))
    obj, lattice = bpy.data.objects[name], bpy.data.objects["Outer"]
    assert np.abs(seen(obj) - shown).max() == 0.0
    choose(obj, lattice)
    assert bpy.ops.isochor.bake_points(frame_start=8, frame_end=10, strength=0.5) == {"FINISHED"}
    assert len(obj.data.shape_keys.key_blocks) == 3
    bpy.context.scene.frame_set(8)
    assert np.abs(seen(obj) - shown).max() > 1e-3
    assert len([data for data in (*bpy.data.curves, *bpy.data.lattices) if "Baked" in data.name]) == 1


def test_a_lattice_animated_by_its_own_keys_is_deformed_as_animated():
    """Nested: muscle over bone. The inner lattice's own animation is what the outer one deforms."""
    inner = scenes.lattice_object(3, name="Inner", size=1.5)
    inner.shape_key_add(name="Basis")
    key = inner.shape_key_add(name="Bulge")
    for point in key.data:
        point.co = np.array(point.co) * 1.3
    for frame in (1, 10):
        key.value = float(frame == 10)
        key.keyframe_insert("value", frame=frame)
    outer = scenes.lattice_object(2, name="Outer", size=6.0)
    for point in outer.data.points:
        point.co_deform.x += 0.5
    choose(inner, outer)
    own = {}
    for frame in (1, 6, 10):
        bpy.context.scene.frame_set(frame)
        own[frame] = seen(inner)
    assert bpy.ops.isochor.bake_points(frame_start=1, frame_end=10) == {"FINISHED"}
    for frame, points in own.items():
        bpy.context.scene.frame_set(frame)
        # The outer lattice moves everything by 3 units of the world, 2 of the inner lattice's.
        assert np.abs(seen(inner) - points - (2.0, 0.0, 0.0)).max() < 1e-6, frame
    ball = scenes.sphere()
    ball.scale = (0.5, 0.5, 0.5)
    bpy.context.view_layer.update()
    modifier = scenes.volume_lattice(ball, inner, Preserve=0.0)
    assert not scenes.report(ball, modifier).problems
    moved = scenes.evaluated_positions(ball) - scenes.positions(ball.data)
    assert moved[:, 0].min() > 5.0


def test_a_bake_that_fails_leaves_everything_as_it_was(moving):
    obj, lattice = moving
    before = everything(obj)
    bpy.ops.isochor.deform_points()
    deformed = read(obj)
    lattice.scale = (0.0, 1.0, 1.0)
    with pytest.raises(RuntimeError, match="scale of zero"):
        bpy.ops.isochor.bake_points(frame_start=1, frame_end=3)
    assert np.abs(read(obj) - deformed).max() == 0.0
    bpy.ops.isochor.restore_points()
    assert everything(obj) == before
