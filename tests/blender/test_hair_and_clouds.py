# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and point clouds: attributes in place of vertex groups, points outside, and several kinds at once."""

import bpy
import numpy as np
import pytest
import scenes
import things


@pytest.fixture(params=["hair", "cloud"])
def moved(request):
    """The object, its modifier, and its points before and after."""
    scenes.empty_file()
    obj = getattr(things, request.param)()
    lattice = scenes.lattice_object(4, size=4.0)
    for index, point in enumerate(lattice.data.points):
        point.co_deform = np.array(point.co_deform) + 0.1 * np.cos(np.arange(3) * index)
    before = points(obj)
    modifier = scenes.volume_lattice(obj, lattice)
    return obj, modifier, before, points(obj)


def points(obj):
    (found,) = things.shown(obj).values()
    return found


def test_strength_and_an_attribute_scale_each_point(moved):
    obj, modifier, before, full = moved
    weights = np.linspace(0.0, 1.0, len(before))
    things.attribute(obj, "Part", weights)
    scenes.set_input(modifier, "Vertex Group", "Part")
    scenes.set_input(modifier, "Strength", 0.5)
    bpy.context.view_layer.update()
    assert not scenes.report(obj, modifier).problems
    assert np.abs(points(obj) - (before + 0.5 * weights[:, None] * (full - before))).max() < 1e-6
    scenes.set_input(modifier, "Invert", True)
    bpy.context.view_layer.update()
    assert np.abs(points(obj) - (before + 0.5 * (1.0 - weights[:, None]) * (full - before))).max() < 1e-6
    scenes.set_input(modifier, "Vertex Group", "Missing")
    bpy.context.view_layer.update()
    assert any("Missing" in text for text in scenes.report(obj, modifier).problems)


def test_points_outside_are_kept_or_follow(moved):
    obj, modifier, before, _full = moved
    lattice = scenes.get_input(modifier, "Lattice")
    lattice.scale = (1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    outside = (np.abs(before) > 0.5 + 1e-6).any(axis=1)
    assert outside.any()
    assert scenes.report(obj, modifier).vertices_outside == outside.sum()
    assert np.abs(points(obj) - before)[outside].max() == 0.0
    scenes.set_input(modifier, "Outside", "Extend")
    bpy.context.view_layer.update()
    assert np.abs(points(obj) - before)[outside].max() > 0.05


def test_edited_points_are_deformed_anew(moved):
    obj, _modifier, before, full = moved
    step = np.array((0.1, -0.05, 0.02))
    obj.data.attributes["position"].data.foreach_set("vector", (before + step).astype(np.float32).ravel())
    obj.data.update_tag()
    bpy.context.view_layer.update()
    once = points(obj)
    obj.data.attributes["position"].data.foreach_set("vector", before.astype(np.float32).ravel())
    obj.data.update_tag()
    bpy.context.view_layer.update()
    assert np.abs(points(obj) - full).max() < 1e-6
    assert np.abs(once - full).max() > 0.02


def joining(*others):
    """A nodes group that joins other objects' geometry with what comes in."""
    group = bpy.data.node_groups.new("Join", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    join = group.nodes.new("GeometryNodeJoinGeometry")
    for other in others:
        info = group.nodes.new("GeometryNodeObjectInfo")
        info.inputs[0].default_value = other
        group.links.new(info.outputs["Geometry"], join.inputs[0])
    group.links.new(group.nodes.new("NodeGroupInput").outputs[0], join.inputs[0])
    group.links.new(join.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    return group


def test_a_mesh_joined_with_curves_and_points_keeps_its_volume_and_takes_them_along():
    """Points and handles that lie where vertices of the ball do stay with them, when its volume is corrected too."""
    ball = scenes.sphere()
    places = scenes.positions(ball.data)
    cloud = things.cloud(40)
    cloud.data.attributes["position"].data.foreach_set("vector", places[100:140].astype(np.float32).ravel())
    curve = things.curve("BEZIER", places[200:204])
    for index, point in enumerate(curve.data.splines[0].bezier_points):
        point.handle_left, point.handle_right = places[210 + index], places[220 + index]
    scenes.choose(ball)
    ball.modifiers.new("Join", "NODES").node_group = joining(cloud, curve)
    lattice = scenes.lattice_object(4, size=2.6)
    modifier = scenes.volume_lattice(ball, lattice)
    for point in lattice.data.points:
        point.co_deform = (point.co.x + 0.3 * point.co.z**2, point.co.y, 0.6 * point.co.z)
    bpy.context.view_layer.update()
    after, report = things.shown(ball), scenes.report(ball, modifier)
    assert not report.problems
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) < 1e-6
    assert np.abs(after["mesh"] - places).max() > 0.1
    for name, first in (("pointcloud", 100), ("curves", 200), ("handle_left", 210), ("handle_right", 220)):
        assert np.abs(after[name] - after["mesh"][first : first + len(after[name])]).max() < 1e-6, name


def test_curves_that_come_after_are_left_alone():
    """A curve joined with the ball behind the modifier stays as it is, and the ball is deformed all the same."""
    curve = things.curve("POLY", things.path(4))
    ball = scenes.sphere()
    modifier = scenes.volume_lattice(ball, scenes.lattice_object(3))
    ball.modifiers.new("Join", "NODES").node_group = joining(curve)
    scenes.set_input(modifier, "Squash", 0.6)
    bpy.context.view_layer.update()
    assert not scenes.report(ball, modifier).problems
    assert np.abs(things.shown(ball)["curves"] - things.path(4)).max() < 1e-6
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) < 1e-6
