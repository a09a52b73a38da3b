# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sidebar says of quads that Blender draws cut along the other diagonal than the one whose volume is kept."""

import re

import bpy
import numpy as np
import pytest
import scenes


def twisted_torus(angle: float, triangulated: bool = False) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    bpy.ops.mesh.primitive_torus_add()
    torus = bpy.context.active_object
    if triangulated:
        torus.modifiers.new("Triangulate", "TRIANGULATE")
    assert bpy.ops.isochor.add() == {"FINISHED"}
    modifier = torus.modifiers[-1]
    scenes.set_input(modifier, "Twist", angle)
    bpy.context.view_layer.update()
    return torus, modifier


def note(torus: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    memory = scenes.part("tool.state").recall(torus, modifier)
    return str(memory.cuts.note(memory.report, memory.faces))


@pytest.mark.parametrize("angle", [2.0, 3.0])
def test_what_is_said_to_be_drawn_is_what_blender_draws(angle):
    torus, modifier = twisted_torus(angle)
    target = scenes.report(torus, modifier).volumes.target
    off = scenes.evaluated_volume(torus) / target - 1.0
    assert abs(off) > 1e-3, "the shape must be one where it matters"
    text = note(torus, modifier)
    said = float(re.search(r"([+-][\d.e-]+) %", text)[1]) / 100.0
    assert said == pytest.approx(off, rel=0.06), text
    count = int(re.search(r"draws (\d+)", text)[1])
    assert 0 < count < len(torus.data.polygons)


def test_numbers_are_exact_to_rounding():
    torus, modifier = twisted_torus(2.0)
    quads = scenes.part("core.quads")
    memory = scenes.part("tool.state").recall(torus, modifier)
    memory.cuts.note(memory.report, memory.faces)
    _count, more = quads.drawn_volume(memory.report.vertices, memory.cuts.quads, memory.cuts.first_to_third)
    volumes = memory.report.volumes
    assert volumes.after + more == pytest.approx(scenes.evaluated_volume(torus), rel=1e-6)


@pytest.mark.parametrize(("angle", "triangulated"), [(0.0, False), (0.5, False), (2.0, True)])
def test_nothing_is_said_where_blender_draws_what_is_kept(angle, triangulated):
    torus, modifier = twisted_torus(angle, triangulated)
    target = scenes.report(torus, modifier).volumes.target
    assert abs(scenes.evaluated_volume(torus) / target - 1.0) < 1e-6
    assert note(torus, modifier) == ""


def test_it_follows_the_shape_and_the_faces():
    torus, modifier = twisted_torus(2.0)
    assert note(torus, modifier)
    scenes.set_input(modifier, "Twist", 0.0)
    bpy.context.view_layer.update()
    assert note(torus, modifier) == ""
    scenes.set_input(modifier, "Twist", 2.0)
    torus.modifiers.new("Triangulate", "TRIANGULATE")
    torus.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    assert note(torus, modifier) == ""


def test_blender_s_rule_is_the_one_of_its_own_triangles():
    torus, _modifier = twisted_torus(2.0)
    quads = scenes.part("core.quads")
    mesh = scenes.evaluated_mesh(torus)
    mesh.calc_loop_triangles()
    triangles = np.array([tuple(triangle.vertices) for triangle in mesh.loop_triangles], np.int32)
    corners = np.array([tuple(face.vertices) for face in mesh.polygons], np.int32)
    drawn = quads.drawn_first_to_third(scenes.positions(mesh), corners)
    assert np.array_equal(drawn, quads.cut_first_to_third(corners, triangles))
    assert 0 < drawn.sum() < len(drawn)
