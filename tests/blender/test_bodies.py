# SPDX-License-Identifier: GPL-3.0-or-later
"""More than one volume: islands, a region with its own target, holes that count as closed."""

import bpy
import numpy as np
import pieces
import pytest
import scenes

EXACT = 1e-6


def two_balls(small: float = 0.5) -> bpy.types.Object:
    points, triangles = scenes.sphere_arrays(20, 12)
    parts = [(0.5 * points - (0.6, 0.0, 0.0), triangles), (small * points + (0.6, 0.0, 0.0), triangles)]
    return pieces.several(parts)


def tapered(lattice: bpy.types.Object) -> None:
    """Thin at low x, thick at high x: one ball loses what the other gains."""
    for point in lattice.data.points:
        point.co_deform.y *= 1.0 + 1.2 * point.co_deform.x
        point.co_deform.z *= 0.8 + 0.6 * point.co_deform.x
    bpy.context.view_layer.update()


def shown_with(modifier: bpy.types.NodesModifier, **inputs) -> None:
    for name, value in inputs.items():
        scenes.set_input(modifier, name.replace("_", " "), value)
    bpy.context.view_layer.update()


def relative(found, expected) -> float:
    return float(np.max(np.abs(np.asarray(found) / np.asarray(expected) - 1.0)))


def grouped(obj: bpy.types.Object, name: str, inside: np.ndarray, weight: float = 1.0) -> np.ndarray:
    obj.vertex_groups.new(name=name).add(np.flatnonzero(inside).tolist(), weight, "REPLACE")
    return inside


@pytest.mark.parametrize("method", ["Balanced", "Sweep", "Gradient", "Nearest"])
def test_every_island_keeps_its_own_volume(method):
    balls = two_balls(0.45)
    rest = pieces.island_volumes(balls)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(balls, lattice, Method=method)
    tapered(lattice)
    together = pieces.island_volumes(balls)
    assert together.sum() == pytest.approx(rest.sum(), rel=EXACT)
    assert relative(together, rest) > 0.1
    shown_with(modifier, Islands=True)
    report = scenes.report(balls, modifier)
    assert report.problems == ()
    assert relative(pieces.island_volumes(balls), rest) <= EXACT
    assert report.volumes.bodies == 2
    assert report.volumes.error <= EXACT
    assert report.volumes.target == pytest.approx(rest.sum(), rel=EXACT)
    sidebar = dict(scenes.part("ui.sidebar").rows(report))
    assert sidebar["Volumes kept"] == "2"
    shown_with(modifier, Target=1.3, Preserve=1.0)
    assert relative(pieces.island_volumes(balls), 1.3 * rest) <= EXACT
    shown_with(modifier, Islands=False)
    assert pieces.island_volumes(balls).sum() == pytest.approx(1.3 * rest.sum(), rel=EXACT)


def test_preserve_restores_that_part_of_each_island():
    balls = two_balls()
    rest = pieces.island_volumes(balls)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(balls, lattice, Preserve=0.0)
    tapered(lattice)
    lost = pieces.island_volumes(balls)
    shown_with(modifier, Islands=True, Preserve=0.25)
    assert relative(pieces.island_volumes(balls), 0.75 * lost + 0.25 * rest) <= 1e-5


def test_an_open_piece_goes_along_and_the_closed_one_keeps_its_volume():
    points, triangles = scenes.sphere_arrays(20, 12)
    patch = np.array([(-0.9, -0.5, 0.0), (-0.1, -0.5, 0.0), (-0.1, 0.5, 0.0), (-0.9, 0.5, 0.0)])
    parts = [(patch, np.array([(0, 1, 2), (0, 2, 3)], np.int32)), (0.5 * points + (0.6, 0.0, 0.0), triangles)]
    obj = pieces.several(parts)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(obj, lattice)
    rest = pieces.island_volumes(obj)[1]
    tapered(lattice)
    assert "hole" in " ".join(scenes.report(obj, modifier).problems)
    flat = scenes.evaluated_positions(obj)[:4]
    shown_with(modifier, Islands=True)
    assert scenes.report(obj, modifier).problems == ()
    assert pieces.island_volumes(obj)[1] == pytest.approx(rest, rel=EXACT)
    assert np.abs(scenes.evaluated_positions(obj)[:4] - flat).max() > 1e-3


def test_an_open_tube_keeps_the_volume_that_it_encloses_with_its_holes_closed():
    obj = scenes.mesh_object("Tube", *pieces.tube())
    triangles = pieces.triangles_of(obj.data)
    assert sum(1 for _loop in pieces.loops(triangles)) == 2
    rest = pieces.volume(scenes.positions(obj.data), triangles)
    assert rest == pytest.approx(16.0 * np.sin(2.0 * np.pi / 32) * 0.36 * 2.0, rel=EXACT)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(obj, lattice)
    for point in lattice.data.points:
        point.co_deform.z *= 0.4
        point.co_deform.x += 0.3 * point.co_deform.z * point.co_deform.y
    bpy.context.view_layer.update()
    problems = " ".join(scenes.report(obj, modifier).problems)
    assert "2 holes" in problems
    assert "32 edges near (0.6, 0, -1)" in problems
    assert "Close Holes" in problems
    plain = scenes.evaluated_positions(obj)
    assert pieces.volume(plain, triangles) == pytest.approx(0.4 * rest, rel=1e-3)
    shown_with(modifier, Close_Holes=True)
    assert scenes.report(obj, modifier).problems == ()
    assert pieces.volume(scenes.evaluated_positions(obj), triangles) == pytest.approx(rest, rel=EXACT)
    assert len(scenes.evaluated_mesh(obj).polygons) == len(obj.data.polygons)
    assert scenes.report(obj, modifier).volumes.error <= EXACT


@pytest.mark.parametrize("islands", [False, True])
def test_a_region_has_a_target_of_its_own_and_the_rest_another(islands):
    ball = scenes.sphere(32, 24)
    inside = grouped(ball, "Head", scenes.positions(ball.data)[:, 2] > 0.3, 0.8)
    rest = pieces.region_volumes(ball, inside)
    lattice = scenes.lattice_object(5)
    modifier = scenes.volume_lattice(ball, lattice, Region="Head", Islands=islands)
    tapered(lattice)
    assert scenes.report(ball, modifier).problems == ()
    assert relative(pieces.region_volumes(ball, inside), rest) <= EXACT
    shown_with(modifier, Region_Target=1.4)
    assert relative(pieces.region_volumes(ball, inside), (1.4 * rest[0], rest[1])) <= EXACT
    shown_with(modifier, Target=0.8)
    assert relative(pieces.region_volumes(ball, inside), (1.4 * rest[0], 0.8 * rest[1])) <= EXACT
    assert scenes.evaluated_volume(ball) == pytest.approx(1.4 * rest[0] + 0.8 * rest[1], rel=EXACT)


def test_a_region_of_one_island_beside_others():
    balls = two_balls(0.4)
    place = scenes.positions(balls.data)
    inside = grouped(balls, "Cap", (place[:, 0] < 0.0) & (place[:, 2] > 0.1))
    points, triangles = scenes.positions(balls.data), pieces.triangles_of(balls.data)
    there = inside[triangles].all(axis=1)
    left = ~there & (points[triangles][:, :, 0].max(axis=1) < 0.0)
    bodies = [triangles[there], triangles[left], triangles[~there & ~left]]
    rest = [pieces.volume(points, body) for body in bodies]
    lattice = scenes.lattice_object(5)
    modifier = scenes.volume_lattice(balls, lattice, Region="Cap", Islands=True, Region_Target=1.2)
    tapered(lattice)
    found = [pieces.volume(scenes.evaluated_positions(balls), body) for body in bodies]
    assert relative(found, np.array(rest) * (1.2, 1.0, 1.0)) <= EXACT
    assert scenes.report(balls, modifier).volumes.bodies == 3


def test_a_missing_or_empty_region_is_told_and_the_whole_keeps_its_volume():
    ball = scenes.sphere()
    whole = scenes.volume(ball.data)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Region="Nose")
    tapered(lattice)
    assert any("“Nose”" in text and "Region" in text for text in scenes.report(ball, modifier).problems)
    assert scenes.evaluated_volume(ball) == pytest.approx(whole, rel=EXACT)
    grouped(ball, "Nose", np.arange(len(ball.data.vertices)) == 3)
    bpy.context.view_layer.update()
    assert any("No face lies" in text for text in scenes.report(ball, modifier).problems)
    assert scenes.evaluated_volume(ball) == pytest.approx(whole, rel=EXACT)
    ball.vertex_groups["Nose"].add([3, 4, 27, 28], 1.0, "REPLACE")
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()
    shown_with(modifier, Region="", Islands=True)
    assert scenes.report(ball, modifier).problems == ()
    shown_with(modifier, Region="Ear")
    assert any("“Ear”" in text for text in scenes.report(ball, modifier).problems)


def test_what_encloses_nothing_is_told_in_plain_words():
    bpy.ops.mesh.primitive_plane_add()
    plane = bpy.context.object
    modifier = scenes.volume_lattice(plane, scenes.lattice_object(3), Islands=True, Preserve=1.0)
    for inputs, said in (
        ({"Islands": True}, "no piece of the mesh is closed"),
        ({"Islands": False, "Close_Holes": True}, "is flat"),
        ({"Target": 1.2}, "is flat"),
    ):
        shown_with(modifier, **inputs)
        assert said in " ".join(scenes.report(plane, modifier).problems)
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    cube = bpy.context.object
    grouped(cube, "Top", scenes.positions(cube.data)[:, 2] > 0.0)
    modifier = scenes.volume_lattice(cube, scenes.lattice_object(3), Region="Top")
    assert "give the Region more faces" in " ".join(scenes.report(cube, modifier).problems)


def test_a_target_of_nothing_is_reached_and_has_an_error_that_is_a_number():
    balls = two_balls()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(balls, lattice, Islands=True, Target=0.0)
    tapered(lattice)
    assert np.abs(pieces.island_volumes(balls)).max() < 1e-6
    assert scenes.report(balls, modifier).volumes.error < 1e-6


def test_the_same_bodies_are_bound_once(monkeypatch):
    """Frames of an animation bind nothing anew, and frames seen before are found again."""
    balls = two_balls()
    grouped(balls, "Part", scenes.positions(balls.data)[:, 2] > 0.0)
    lattice = scenes.squashing_lattice(balls, 6, frames=8)
    modifier = scenes.volume_lattice(balls, lattice, Basis="B-Spline", Islands=True, Region="Part")
    bpy.context.scene.frame_set(1)
    binding = scenes.report(balls, modifier).binding
    for frame in range(2, 8):
        bpy.context.scene.frame_set(frame)
        assert scenes.report(balls, modifier).binding is binding
    shown_with(modifier, Region="")
    assert scenes.report(balls, modifier).binding is not binding


def test_faces_added_to_a_mesh_are_divided_anew():
    balls = two_balls()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(balls, lattice, Islands=True)
    tapered(lattice)
    points, triangles = scenes.sphere_arrays(12, 8)
    whole = pieces.several([(0.2 * points + (0.0, 0.7, 0.0), triangles)], "More").data
    import bmesh

    held = bmesh.new()
    held.from_mesh(balls.data)
    held.from_mesh(whole)
    held.to_mesh(balls.data)
    balls.data.update()
    scenes.choose(balls)
    bpy.ops.isochor.set_rest()
    rest = pieces.island_volumes(balls)
    assert len(rest) == 3
    for point in lattice.data.points:
        point.co_deform.z *= 0.7
    bpy.context.view_layer.update()
    assert scenes.report(balls, modifier).volumes.bodies == 3
    assert scenes.report(balls, modifier).volumes.error <= EXACT


def test_double_precision_measures_what_is_shown():
    from installed_extension import MODULE

    preferences = bpy.context.preferences.addons[MODULE].preferences
    balls = two_balls(0.4)
    rest = pieces.island_volumes(balls)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(balls, lattice, Islands=True)
    preferences.precision = "DOUBLE"
    try:
        tapered(lattice)
        volumes = scenes.report(balls, modifier).volumes
        found = pieces.island_volumes(balls)
        assert relative(found, rest) <= EXACT
        assert volumes.error == pytest.approx(relative(found, rest), abs=1e-9)
        assert volumes.error > 0.0
    finally:
        preferences.precision = "SINGLE"
