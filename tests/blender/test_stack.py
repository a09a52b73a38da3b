# SPDX-License-Identifier: GPL-3.0-or-later
"""Other modifiers before, after and between ours."""

import bpy
import lattice_oracle
import numpy as np
import scenes


def squash(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def before_ours(obj: bpy.types.Object, name: str, kind: str) -> bpy.types.Modifier:
    modifier = obj.modifiers.new(name, kind)
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    return modifier


def armature_on(ball: bpy.types.Object) -> bpy.types.Object:
    """Two bones, the upper one holding the upper half of the ball."""
    rig = scenes.linked(bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
    bpy.ops.object.mode_set(mode="EDIT")
    for name, low, high in (("Lower", -1.0, 0.0), ("Upper", 0.0, 1.0)):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = (0.0, 0.0, low), (0.0, 0.0, high)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name in ("Lower", "Upper"):
        group = ball.vertex_groups.new(name=name)
        chosen = [v.index for v in ball.data.vertices if (v.co.z >= 0) == (name == "Upper")]
        group.add(chosen, 1.0, "REPLACE")
    ball.modifiers.new("Armature", "ARMATURE").object = rig
    return rig


def test_armature_before_ours():
    ball = scenes.sphere()
    rig = armature_on(ball)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    whole = scenes.volume(ball.data)
    squash(lattice)
    bone = rig.pose.bones["Upper"]
    bone.scale = (1.0, 1.0, 1.0)
    bone.keyframe_insert("scale", frame=1)
    bone.scale = (0.6, 0.7, 0.6)
    bone.keyframe_insert("scale", frame=10)
    for frame in (1, 5, 10):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    ours = scenes.evaluated_positions(ball)
    modifier.show_viewport = False
    bpy.context.view_layer.update()
    posed = scenes.evaluated_positions(ball)
    assert np.abs(posed - scenes.positions(ball.data)).max() > 0.1
    assert np.abs(ours - lattice_oracle.deformed(ball, lattice, posed, "Bernstein")).max() < 2e-6


def test_subdivision_before_ours():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    subdivision = cube.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 2, 3
    bpy.context.view_layer.update()
    smooth = scenes.evaluated_positions(cube)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(cube, lattice, Preserve=0.0)
    squash(lattice)
    wanted = lattice_oracle.deformed(cube, lattice, smooth, "Bernstein")
    assert np.abs(scenes.evaluated_positions(cube) - wanted).max() < 2e-6
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert scenes.report(cube, modifier).problems == ()
    assert scenes.report(cube, modifier).volumes.error <= 1e-6
    volumes = [scenes.get_input(modifier, f"{mode} Result")["isochor_rest_volume"] for mode in ("Viewport", "Render")]
    for level, kept in zip((2, 3), volumes, strict=True):
        modifier.show_viewport = False
        subdivision.levels = level
        bpy.context.view_layer.update()
        assert abs(kept / scenes.evaluated_volume(cube) - 1) <= 1e-6
    assert volumes[0] != volumes[1]


def test_subdivision_after_ours():
    ball = scenes.sphere(12, 8)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squash(lattice)
    alone = scenes.evaluated_positions(ball)
    subdivision = ball.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = 2
    bpy.context.view_layer.update()
    result = scenes.get_input(modifier, "Viewport Result").data
    assert len(scenes.evaluated_mesh(ball).vertices) > 4 * len(alone)
    for factor in (0.8, 0.9):
        squash(lattice, factor)
        found = scenes.positions(result)
        subdivision.show_viewport = False
        bpy.context.view_layer.update()
        assert np.array_equal(scenes.evaluated_positions(ball), found)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
        subdivision.show_viewport = True
        bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()


def test_modifiers_after_ours_that_add_vertices_at_the_end():
    for kind in ("SOLIDIFY", "ARRAY", "MIRROR"):
        scenes.empty_file()
        ball = scenes.sphere(12, 8)
        lattice = scenes.lattice_object(4)
        modifier = scenes.volume_lattice(ball, lattice)
        ball.modifiers.new("After", kind)
        squash(lattice)
        assert scenes.report(ball, modifier).problems == (), kind
        assert scenes.report(ball, modifier).volumes.before < 0.55 * scenes.volume(ball.data), kind


def rounding(ball: bpy.types.Object) -> bpy.types.Modifier:
    """A Bevel, which replaces every vertex."""
    bevel = ball.modifiers.new("Round Edges", "BEVEL")
    bevel.limit_method = "NONE"
    bevel.width = 0.01
    return bevel


def test_modifier_after_ours_may_replace_the_vertices_where_nothing_comes_before():
    ball = scenes.sphere(12, 8)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    bevel = rounding(ball)
    squash(lattice)
    assert scenes.report(ball, modifier).problems == ()
    assert np.ptp(scenes.evaluated_positions(ball), axis=0)[2] < 1.7
    bevel.show_viewport = False
    squash(lattice, 0.9)
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_modifier_after_ours_that_replaces_vertices_made_before_leaves_the_mesh_undeformed_and_says_so():
    ball = scenes.sphere(12, 8)
    ball.modifiers.new("Push Out", "DISPLACE").strength = 0.01
    rounding(ball)
    bpy.context.view_layer.update()
    undeformed = scenes.evaluated_positions(ball)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    ball.modifiers.move(2, 1)
    squash(lattice)
    (text,) = scenes.report(ball, modifier).problems
    assert "Round Edges" in text
    assert "move Volume Lattice below" in text
    assert np.abs(scenes.evaluated_positions(ball) - undeformed).max() < 1e-6
    ball.modifiers.move(1, 2)
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    assert np.ptp(scenes.evaluated_positions(ball), axis=0)[2] < 1.7


def test_faces_changed_before_and_after_ours_still_deform_and_the_report_says_what_is_missing():
    ball = scenes.sphere(12, 8)
    ball.modifiers.new("First", "SUBSURF")
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    ball.modifiers.new("Second", "SUBSURF")
    squash(lattice)
    (text,) = scenes.report(ball, modifier).problems
    assert "First" in text
    assert "Second" in text
    assert np.ptp(scenes.evaluated_positions(ball), axis=0)[2] < 1.1


def test_two_of_ours_in_the_same_frame_without_lag():
    ball = scenes.sphere()
    first = scenes.squashing_lattice(ball, 6, frames=20)
    second = scenes.lattice_object(4, name="Second", size=3.2)
    second.shape_key_add(name="Basis")
    key = second.shape_key_add(name="Bulge")
    for point in key.data:
        point.co.x += 0.4 * point.co.z**2
    for frame, value in ((1, 0.0), (20, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_set(1)
    one = scenes.volume_lattice(ball, first, Basis="B-Spline", Preserve=0.0)
    two = scenes.volume_lattice(ball, second, Preserve=0.0)
    for frame in (1, 8, 13):
        bpy.context.scene.frame_set(frame)
        between = lattice_oracle.deformed(ball, first, scenes.positions(ball.data), "B-Spline")
        wanted = lattice_oracle.deformed(ball, second, between, "Bernstein")
        assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 3e-6
    for modifier in (one, two):
        scenes.set_input(modifier, "Preserve", 1.0)
    for frame in (9, 14):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
        assert scenes.report(ball, two).problems == ()


def test_another_modifier_between_two_of_ours_is_named():
    ball = scenes.sphere()
    lattices = [scenes.lattice_object(4, name=name) for name in ("One", "Two")]
    scenes.volume_lattice(ball, lattices[0])
    ball.modifiers.new("Push Out", "DISPLACE")
    last = scenes.volume_lattice(ball, lattices[1])
    bpy.context.view_layer.update()
    assert any("Push Out" in text for text in scenes.report(ball, last).problems)


def test_problem_of_what_stands_between_goes_away_with_it():
    ball = scenes.sphere()
    scenes.volume_lattice(ball, scenes.lattice_object(4, name="One"))
    between = ball.modifiers.new("Weighted", "WEIGHTED_NORMAL")
    last = scenes.volume_lattice(ball, scenes.lattice_object(4, name="Two"))
    bpy.context.view_layer.update()
    assert any("Weighted" in text for text in scenes.report(ball, last).problems)
    ball.modifiers.remove(between)
    bpy.context.view_layer.update()
    assert scenes.report(ball, last).problems == ()


def test_order_of_modifiers_can_change():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    squash(lattice)
    displace = ball.modifiers.new("Push Out", "DISPLACE")
    displace.strength = 0.1
    bpy.context.view_layer.update()
    after = scenes.evaluated_positions(ball)
    ball.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - after).max() > 0.01
    assert np.ptp(scenes.evaluated_positions(ball)[:, 2]) < np.ptp(after[:, 2])
