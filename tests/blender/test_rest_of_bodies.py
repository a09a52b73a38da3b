# SPDX-License-Identifier: GPL-3.0-or-later
"""The volumes at rest of several bodies: behind an armature, turned on while posed, set anew, and in renders."""

import bpy
import numpy as np
import pieces
import pytest
import scenes

EXACT = 1e-6


def two_cylinders(radius: float = 0.3) -> bpy.types.Object:
    points, triangles = pieces.cylinder(radius=radius)
    return pieces.several([(points - (0.6, 0, 0), triangles), (1.2 * points + (0.6, 0, 0), triangles)])


def bent_by_bones(obj: bpy.types.Object, frames: int = 10) -> bpy.types.Object:
    """Two bones along z, the upper one turned by 100° over the frames, with weights that fade over the joint; the
    modifier stands first."""
    armature = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
    scenes.linked(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = armature.data.edit_bones
    for name, low, high in (("Lower", -1.2, 0.0), ("Upper", 0.0, 1.2)):
        bone = edit.new(name)
        bone.head, bone.tail = (0.0, 0.0, low), (0.0, 0.0, high)
    bpy.ops.object.mode_set(mode="OBJECT")
    heights = scenes.positions(obj.data)[:, 2]
    upper = np.clip(0.5 + heights / 0.6, 0.0, 1.0)
    for name, weights in (("Lower", 1.0 - upper), ("Upper", upper)):
        group = obj.vertex_groups.new(name=name)
        for index, weight in enumerate(weights):
            group.add([index], float(weight), "REPLACE")
    pose = armature.pose.bones["Upper"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (frames, np.radians(100.0))):
        pose.rotation_euler.x = angle
        pose.keyframe_insert("rotation_euler", frame=frame)
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    bpy.context.scene.frame_set(1)
    scenes.choose(obj)
    return armature


def lattice_around(obj: bpy.types.Object, **inputs) -> bpy.types.NodesModifier:
    return scenes.volume_lattice(obj, scenes.lattice_object((4, 6, 6), size=5.0), **inputs)


def shown_with(modifier: bpy.types.NodesModifier, **inputs) -> None:
    for name, value in inputs.items():
        scenes.set_input(modifier, name.replace("_", " "), value)
    bpy.context.view_layer.update()


def relative(found, expected) -> float:
    return float(np.max(np.abs(np.asarray(found) / np.asarray(expected) - 1.0)))


def kept(modifier: bpy.types.NodesModifier, mode: str) -> str | None:
    return scenes.get_input(modifier, f"{mode} Result").get("isochor_rest_parts")


def test_what_skinning_loses_comes_back_with_rest_and_is_not_counted_with_incoming():
    obj = scenes.mesh_object("Arm", *pieces.cylinder())
    rest = scenes.volume(obj.data)
    bent_by_bones(obj)
    bpy.context.scene.frame_set(10)
    skinned, lost = scenes.evaluated_positions(obj), scenes.evaluated_volume(obj)
    assert lost < 0.95 * rest
    bpy.context.scene.frame_set(1)
    modifier = lattice_around(obj, Reference="Incoming")
    bpy.context.scene.frame_set(10)
    assert scenes.report(obj, modifier).problems == ()
    assert scenes.evaluated_volume(obj) == pytest.approx(lost, rel=EXACT)
    assert np.abs(scenes.evaluated_positions(obj) - skinned).max() < 1e-5
    shown_with(modifier, Reference="Rest")
    for frame in (3, 5, 7, 10):
        bpy.context.scene.frame_set(frame)
        assert scenes.evaluated_volume(obj) == pytest.approx(rest, rel=EXACT)
    assert np.abs(scenes.evaluated_positions(obj) - skinned).max() > 1e-3


def test_every_island_gets_back_what_skinning_took_from_it():
    obj = two_cylinders()
    rest = pieces.island_volumes(obj)
    bent_by_bones(obj)
    modifier = lattice_around(obj, Islands=True)
    for frame in (4, 7, 10):
        bpy.context.scene.frame_set(frame)
        assert scenes.report(obj, modifier).problems == ()
        assert relative(pieces.island_volumes(obj), rest) <= EXACT
    shown_with(modifier, Reference="Incoming", Preserve=0.0)
    incoming = pieces.island_volumes(obj)
    assert relative(incoming, rest) > 0.01
    shown_with(modifier, Preserve=1.0)
    assert relative(pieces.island_volumes(obj), incoming) <= EXACT


def test_islands_turned_on_in_a_pose_share_the_volume_of_the_rest():
    """What each was at rest cannot be known then; together they have the volume that is kept."""
    obj = two_cylinders()
    whole = scenes.volume(obj.data)
    bent_by_bones(obj)
    modifier = lattice_around(obj)
    bpy.context.scene.frame_set(10)
    shown_with(modifier, Islands=True)
    in_pose = pieces.island_volumes(obj)
    assert in_pose.sum() == pytest.approx(whole, rel=EXACT)
    bpy.context.scene.frame_set(5)
    assert relative(pieces.island_volumes(obj), in_pose) <= EXACT


def test_set_rest_measures_every_body_anew():
    obj = two_cylinders()
    rest = pieces.island_volumes(obj)
    bent_by_bones(obj)
    bpy.context.scene.frame_set(10)
    modifier = lattice_around(obj, Islands=True)
    bpy.context.scene.frame_set(1)
    assert relative(pieces.island_volumes(obj), rest) > 0.01
    scenes.choose(obj)
    bpy.ops.isochor.set_rest()
    assert relative(pieces.island_volumes(obj), rest) <= EXACT
    bpy.context.scene.frame_set(10)
    assert relative(pieces.island_volumes(obj), rest) <= EXACT
    shown_with(modifier, Islands=False)
    assert scenes.evaluated_volume(obj) == pytest.approx(rest.sum(), rel=EXACT)


def test_renders_have_the_volumes_of_the_viewport_and_reopened_files_too(tmp_path):
    obj = two_cylinders()
    rest = pieces.island_volumes(obj)
    bent_by_bones(obj)
    modifier = lattice_around(obj, Islands=True)
    assert kept(modifier, "Viewport") == kept(modifier, "Render") is not None
    bpy.context.scene.frame_set(10)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bent.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bent.blend"))
    obj = bpy.data.objects["Pieces"]
    assert relative(pieces.island_volumes(obj), rest) <= EXACT
    bpy.context.scene.frame_set(6)
    assert relative(pieces.island_volumes(obj), rest) <= EXACT


def test_a_render_with_another_subdivision_has_volumes_of_its_own(tmp_path):
    obj = two_cylinders()
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 0, 1
    scenes.choose(obj)
    modifier = scenes.volume_lattice(obj, scenes.lattice_object(4, size=4.0), Islands=True)
    assert kept(modifier, "Render") is None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "levels.blend"))
    shown, rendered = kept(modifier, "Viewport"), kept(modifier, "Render")
    assert shown is not None
    assert rendered is not None
    assert shown != rendered


def test_a_region_painted_anew_is_measured_anew():
    ball = scenes.sphere(32, 24)
    heights = scenes.positions(ball.data)[:, 2]
    group = ball.vertex_groups.new(name="Head")
    group.add(np.flatnonzero(heights > 0.5).tolist(), 1.0, "REPLACE")
    lattice = scenes.lattice_object(5)
    modifier = scenes.volume_lattice(ball, lattice, Region="Head")
    inside = heights > 0.1
    rest = pieces.region_volumes(ball, inside)
    group.add(np.flatnonzero(inside).tolist(), 1.0, "REPLACE")
    bpy.context.view_layer.update()
    for point in lattice.data.points:
        point.co_deform.x *= 1.0 + point.co_deform.z
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert relative(pieces.region_volumes(ball, inside), rest) <= EXACT
    assert kept(modifier, "Viewport").count("r:") == 1


def test_a_bake_holds_the_volume_of_every_island():
    obj = two_cylinders()
    rest = pieces.island_volumes(obj)
    lattice = scenes.squashing_lattice(obj, 6, frames=6)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 6
    bpy.context.scene.frame_set(1)
    scenes.volume_lattice(obj, lattice, Basis="B-Spline", Islands=True)
    scenes.choose(obj)
    assert bpy.ops.isochor.bake(format="SHAPE_KEYS") == {"FINISHED"}
    assert scenes.part("tool.baked").is_playing(obj)
    for frame in range(1, 7):
        bpy.context.scene.frame_set(frame)
        assert relative(pieces.island_volumes(obj), rest) <= EXACT
