# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts and curves that Blender turns into meshes before the modifier: closed ones keep their volume."""

import bpy
import numpy as np
import pytest
import scenes
import things


def tube():
    """A closed tube along a Bézier circle, a solid torus."""
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.context.object.data.bevel_depth = 0.2
    return bpy.context.object


def welded_text():
    """An extruded text whose faces a Weld modifier joins."""
    obj = things.text()
    obj.modifiers.new("Weld", "WELD").merge_threshold = 1e-4
    return obj


def volume(obj):
    holder = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    return scenes.volume(holder.mesh)


@pytest.mark.parametrize("make", [tube, welded_text])
def test_a_closed_one_keeps_its_volume_and_a_moving_body(make):
    obj = make()
    # Triangles are cut one way then, in Blender and here.
    obj.modifiers.new("Triangulate", "TRIANGULATE")
    bpy.context.view_layer.update()
    before = volume(obj)
    bpy.ops.isochor.add(resolution=(4, 4, 3))
    modifier = obj.modifiers.active
    lattice = scenes.get_input(modifier, "Lattice")
    for point in lattice.data.points:
        point.co_deform = np.array(point.co_deform) * (0.6, 1.0, 0.8) + (0.2 * point.co.y**2, 0.0, 0.0)
    bpy.context.view_layer.update()
    report = scenes.report(obj, modifier)
    assert not report.problems
    assert report.keeps_volume
    assert abs(volume(obj) / before - 1.0) < 1e-6
    assert abs(report.volumes.before / before - 1.0) > 0.2
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    assert abs(volume(obj) / before - 1.0) > 0.2


def test_typing_another_text_says_that_its_volume_is_an_old_one():
    obj = welded_text()
    bpy.ops.isochor.add()
    modifier = obj.modifiers.active
    obj.data.body = "Isochor"
    bpy.context.view_layer.update()
    assert scenes.part("core.problem").EDITED in scenes.report(obj, modifier).problems
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert not scenes.report(obj, modifier).problems
    scenes.set_input(modifier, "Squash", 0.7)
    bpy.context.view_layer.update()
    assert abs(scenes.report(obj, modifier).volumes.error) < 1e-6


def test_an_open_one_deforms_and_says_how_to_close_it():
    obj = things.text()
    bpy.ops.isochor.add()
    assert any("not closed" in text for text in scenes.report(obj, obj.modifiers.active).problems)
    noted = scenes.part("ui.sidebar").notes(obj, obj.modifiers.active)
    assert scenes.part("core.problem").NOT_WELDED in noted


def test_a_curve_deforms_while_it_is_edited():
    obj = things.curve("POLY", things.path(5))
    bpy.ops.isochor.add()
    lattice = scenes.get_input(obj.modifiers.active, "Lattice")
    bpy.ops.object.mode_set(mode="EDIT")
    for point in lattice.data.points:
        point.co_deform.z += 0.5
    bpy.context.view_layer.update()
    moved = things.shown(obj)["curves"][:, 2] - things.path(5)[:, 2]
    step = 0.5 * lattice.scale.z
    assert np.abs(moved - step).max() < 2e-6
    bpy.ops.object.mode_set(mode="OBJECT")


def test_in_edit_mode_the_selected_points_are_fitted():
    obj = things.curve("BEZIER", things.path(5))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.curve.select_all(action="DESELECT")
    for point in obj.data.splines[0].bezier_points[:2]:
        point.select_control_point = True
    assert bpy.ops.isochor.add(margin=0.0) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    lattice = scenes.get_input(obj.modifiers.active, "Lattice")
    chosen = obj.data.splines[0].bezier_points[:2]
    places = np.array([place for point in chosen for place in (point.co, point.handle_left, point.handle_right)])
    assert np.allclose(lattice.scale, np.ptp(places, axis=0), rtol=1e-4)


def test_what_comes_after_may_add_to_the_text_but_not_replace_it():
    obj = welded_text()
    bpy.ops.isochor.add()
    modifier = obj.modifiers.active
    obj.modifiers.new("Array", "ARRAY").count = 2
    scenes.set_input(modifier, "Squash", 0.6)
    bpy.context.view_layer.update()
    report = scenes.report(obj, modifier)
    assert not [text for text in report.problems if "replaces the vertices" in text]
    obj.modifiers.new("Remesh", "REMESH")
    bpy.context.view_layer.update()
    assert any("replaces the vertices" in text for text in scenes.report(obj, modifier).problems)
