# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that cannot work: Blender goes on, the mesh shows the uncorrected deformation, the message says what to do."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes


def squash(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def problems(obj: bpy.types.Object) -> str:
    return " | ".join(scenes.report(obj, obj.modifiers[0]).problems)


def height(obj: bpy.types.Object) -> float:
    return float(np.ptp(scenes.evaluated_positions(obj)[:, 2]))


def ball_without(faces: int):
    points, triangles = scenes.sphere_arrays(24, 16)
    return scenes.mesh_object("Holed", points, triangles[faces:])


def test_open_mesh_deforms_and_the_message_says_to_close_it(capfd):
    ball = ball_without(1)
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    for frame in range(2, 5):
        bpy.context.scene.frame_set(frame)
    assert "hole" in problems(ball)
    assert "close" in problems(ball)
    assert height(ball) == pytest.approx(0.5 * np.ptp(scenes.positions(ball.data)[:, 2]), rel=1e-5)
    printed = capfd.readouterr().out
    assert printed.count("Isochor: Holed: ") == 1


def test_inconsistent_winding():
    points, triangles = scenes.sphere_arrays(24, 16)
    triangles[5] = triangles[5][::-1]
    ball = scenes.mesh_object("Mixed", points, triangles)
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    assert problems(ball)
    assert height(ball) < 1.1


def test_mesh_without_vertices_and_without_faces():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    ball.data.clear_geometry()
    bpy.context.view_layer.update()
    assert "no vertices" in problems(ball)
    ball.data.vertices.add(3)
    ball.data.attributes["position"].data.foreach_set("vector", np.arange(9, dtype=np.float32) * 0.1)
    ball.data.update()
    bpy.context.view_layer.update()
    assert "no faces" in problems(ball)
    assert np.allclose(scenes.evaluated_positions(ball)[:, 2], 0.5 * np.array([0.2, 0.5, 0.8]), atol=1e-6)


def flat_ball(tilt: float) -> bpy.types.Object:
    """A closed ball pressed to a sheet, turned about its x axis."""
    points, triangles = scenes.sphere_arrays(24, 16)
    points[:, 2] = 0.0
    turn = np.array([(1, 0, 0), (0, np.cos(tilt), -np.sin(tilt)), (0, np.sin(tilt), np.cos(tilt))])
    return scenes.mesh_object("Sheet", points @ turn.T, triangles)


@pytest.mark.parametrize("tilt", [0.0, 0.7])
@pytest.mark.parametrize("inputs", [{}, {"Reference": "Incoming"}, {"Target": 1.3}])
def test_flat_closed_mesh_is_deformed_uncorrected_and_the_message_says_so(tilt, inputs):
    sheet = flat_ball(tilt)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(sheet, lattice, Preserve=1.0, **inputs)
    for index, point in enumerate(lattice.data.points):
        point.co_deform.x *= 0.5
        point.co_deform.z += 0.1 * np.sin(index)
    bpy.context.view_layer.update()
    assert "flat" in problems(sheet)
    assert "Solidify" in problems(sheet)
    assert "isochor_rest_volume" not in scenes.get_input(modifier, "Viewport Result")
    assert "isochor_rest_volume" not in scenes.get_input(modifier, "Render Result")
    shown = scenes.evaluated_positions(sheet)
    wanted = lattice_oracle.deformed(sheet, lattice, scenes.positions(sheet.data), "Bernstein")
    assert np.abs(shown - wanted).max() < 2e-6


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_mesh_that_becomes_flat_is_deformed_uncorrected(tilt):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    ball.data.attributes["position"].data.foreach_set(
        "vector", scenes.positions(flat_ball(tilt).data).astype(np.float32).reshape(-1)
    )
    ball.data.update()
    lattice.data.points[0].co_deform.x += 0.2
    bpy.context.view_layer.update()
    assert "flat" in problems(ball)
    wanted = lattice_oracle.deformed(ball, lattice, scenes.positions(ball.data), "Bernstein")
    assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 2e-6


def test_vertex_that_is_not_a_number():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    before = ball.data.vertices[7].co.x
    ball.data.vertices[7].co.x = float("nan")
    ball.data.update()
    bpy.context.view_layer.update()
    assert "7" in problems(ball)
    ball.data.vertices[7].co.x = before
    ball.data.update()
    bpy.context.view_layer.update()
    assert problems(ball) == ""
    assert height(ball) < 1.6


@pytest.mark.parametrize("axis", [0, 2])
def test_lattice_and_object_scaled_to_nothing(axis):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    for obj, name in ((lattice, "Lattice"), (ball, "Ball")):
        size = obj.scale[axis]
        obj.scale[axis] = 0.0
        bpy.context.view_layer.update()
        assert f"“{name}” has a scale of zero" in problems(ball)
        assert np.array_equal(scenes.evaluated_positions(ball), scenes.positions(ball.data))
        obj.scale[axis] = size
        bpy.context.view_layer.update()
        assert problems(ball) == ""
        assert height(ball) < 1.6


def test_no_lattice_and_something_that_is_none():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squash(lattice)
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    assert problems(ball).startswith("No lattice: pick")
    assert np.array_equal(scenes.evaluated_positions(ball), scenes.positions(ball.data))
    empty = bpy.data.objects.new("Handle", None)
    bpy.context.scene.collection.objects.link(empty)
    for wrong, kind in ((empty, "empty"), (scenes.sphere(name="Other"), "mesh")):
        scenes.set_input(modifier, "Lattice", wrong)
        bpy.context.view_layer.update()
        assert f"is a {kind}, not a lattice" in problems(ball)


@pytest.mark.parametrize("shares", [(0.0, 0.0, 0.0), (-1.0, 1.0, 1.0)])
def test_shares_that_allow_nothing(shares):
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Axes=shares)
    squash(lattice)
    if min(shares) < 0 and problems(ball) == "":
        pytest.fail("a negative share was taken without a word")
    assert problems(ball)
    assert height(ball) == pytest.approx(0.5 * np.ptp(scenes.positions(ball.data)[:, 2]), rel=1e-5)


def test_target_that_cannot_be_reached():
    ball = scenes.sphere()
    group = ball.vertex_groups.new(name="None")
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Vertex_Group=group.name, Target=1.5)
    squash(lattice)
    assert problems(ball)
    assert np.array_equal(scenes.evaluated_positions(ball), scenes.positions(ball.data))


def test_vertex_group_that_is_not_there():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice, Vertex_Group="Upper")
    squash(lattice)
    assert "no vertex group “Upper”" in problems(ball)
    assert height(ball) < 1.6
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_lattice_resolution_changed_during_playback():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    whole = scenes.volume(ball.data)
    for frame, side in enumerate((5, 2, 1, 7, 4), start=2):
        lattice.data.points_u = side
        lattice.data.points_w = max(2, side)
        bpy.context.scene.frame_set(frame)
        assert problems(ball) == "", side
        assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6
        lattice.data.points[0].co_deform.x += 0.1


def test_basis_with_too_few_points():
    ball = scenes.sphere()
    for side in (1, 2, 3):
        lattice = scenes.lattice_object((side, side, 2), name=f"Small {side}", size=6.0)
        modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline", Preserve=0.0)
        assert scenes.report(ball, modifier).problems == ()
        assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 2e-6
        ball.modifiers.remove(modifier)


def test_mesh_edited_during_playback():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=3.0)
    modifier = scenes.volume_lattice(ball, lattice, Reference="Incoming")
    squash(lattice)
    for frame, (columns, rows) in enumerate(((24, 17), (12, 8), (24, 16), (24, 16)), start=2):
        points, triangles = scenes.sphere_arrays(columns, rows)
        ball.data.clear_geometry()
        ball.data.from_pydata(points.tolist(), [], triangles.tolist())
        ball.data.update()
        bpy.context.scene.frame_set(frame)
        assert problems(ball) == ""
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    faces = np.array([polygon.vertices[:] for polygon in ball.data.polygons])
    points = scenes.positions(ball.data)
    order = np.random.default_rng(1).permutation(len(points))
    places = np.empty_like(order)
    places[order] = np.arange(len(order))
    ball.data.clear_geometry()
    ball.data.from_pydata(points[order].tolist(), [], places[faces].tolist())
    ball.data.update()
    bpy.context.scene.frame_set(9)
    assert problems(ball) == ""
    assert scenes.report(ball, modifier).volumes.error <= 1e-6
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_faces_changed_behind_an_unchanged_count():
    """The same vertices, with as many faces, but others: the volume must be that of the new ones."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Reference="Incoming")
    squash(lattice)
    ball.data.flip_normals()
    bpy.context.view_layer.update()
    assert scenes.evaluated_volume(ball) < 0
    assert scenes.report(ball, modifier).inside_out
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_object_that_is_no_mesh_any_more():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    bpy.ops.object.select_all(action="DESELECT")
    scenes.choose(ball)
    bpy.ops.object.convert(target="MESH")
    assert not ball.modifiers
    bpy.context.scene.frame_set(3)
    assert abs(scenes.volume(ball.data)) == pytest.approx(4.229, rel=1e-3)
