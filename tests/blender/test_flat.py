# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat objects and lines: one layer of the lattice where there is no thickness, and everything works on it."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
import things


def grid_mesh(count: int = 6):
    """A square of side 2 in the plane of x and y."""
    side = np.linspace(-1.0, 1.0, count)
    points = [(x, y, 0.0) for y in side for x in side]
    here = np.arange(count * count).reshape(count, count)
    faces = np.stack([here[:-1, :-1], here[:-1, 1:], here[1:, 1:], here[1:, :-1]], axis=-1).reshape(-1, 4)
    return scenes.mesh_object("Sheet", points, faces)


def drawn_curve():
    obj = things.curve("NURBS", [(x, np.sin(2.0 * x), 0.0) for x in np.linspace(-1.0, 1.0, 6)])
    obj.data.dimensions = "2D"
    return obj


MAKERS = {
    "sheet": (grid_mesh, (4, 4, 1)),
    "curve": (drawn_curve, (4, 4, 1)),
    "text": (lambda: things.text(extrude=0.0), (4, 4, 1)),
    "line": (lambda: things.curve("POLY", [(0.0, y, 0.0) for y in (0.0, 0.5, 2.0)]), (1, 4, 1)),
    "edge": (lambda: scenes.mesh_object("Edge", [(0, 0, 0), (0, 0, 1), (0, 0, 3)], []), (1, 1, 4)),
}


@pytest.fixture(params=MAKERS)
def made(request):
    """The object, its modifier and lattice, its points before, and the shape that the lattice should have."""
    scenes.empty_file()
    make, shape = MAKERS[request.param]
    obj = make()
    obj.location, obj.rotation_euler, obj.scale = (2.0, -1.0, 0.5), (0.4, -0.8, 1.9), (1.4, 0.7, 1.1)
    bpy.context.view_layer.update()
    before = things.shown(obj)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    modifier = obj.modifiers.active
    return obj, modifier, scenes.get_input(modifier, "Lattice"), before, shape


def points_of(lattice):
    return tuple(control for control in (lattice.data.points_u, lattice.data.points_v, lattice.data.points_w))


def test_the_lattice_has_one_layer_and_nothing_is_wrong(made):
    obj, modifier, lattice, before, shape = made
    assert points_of(lattice) == shape
    report = scenes.report(obj, modifier)
    assert not report.problems
    assert report.vertices_outside == 0
    assert scenes.get_input(modifier, "Preserve") == 0.0
    for name, points in things.shown(obj).items():
        assert np.abs(points - before[name]).max() < 2e-6


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_its_points_move_the_object_out_of_its_plane_too(made, basis):
    obj, modifier, lattice, before, _shape = made
    scenes.set_input(modifier, "Basis", basis)
    scenes.set_input(modifier, "Outside", "Extend")
    random = np.random.default_rng(5)
    for point in lattice.data.points:
        point.co_deform = np.array(point.co_deform) + random.uniform(-0.3, 0.3, 3)
    bpy.context.view_layer.update()
    for name, points in things.shown(obj).items():
        assert np.abs(points - before[name]).max() > 0.02
        if basis == "Bernstein":
            wanted = flat_oracle(obj, lattice, before[name])
            assert np.abs(points - wanted).max() < 3e-6, name


def flat_oracle(obj, lattice, points):
    """The oracle moves points to where control points blend; here the plane of one layer stays where points were."""
    blended = lattice_oracle.deformed(obj, lattice, points, "Bernstein")
    moved = [tuple(point.co_deform) for point in lattice.data.points]
    for point in lattice.data.points:
        point.co_deform = point.co
    bpy.context.view_layer.update()
    rest = lattice_oracle.deformed(obj, lattice, points, "Bernstein")
    for point, place in zip(lattice.data.points, moved, strict=True):
        point.co_deform = place
    bpy.context.view_layer.update()
    return points + blended - rest


@pytest.mark.parametrize("name", ["Squash", "Taper", "Twist", "Bend"])
def test_the_panel_animate_and_the_overlay_work(made, name):
    obj, modifier, _lattice, before, shape = made
    axis = "XYZ"[int(np.argmax(shape))]
    scenes.set_input(modifier, "Axis", axis)
    scenes.set_input(modifier, name, 0.5)
    bpy.context.view_layer.update()
    assert not scenes.report(obj, modifier).problems
    after = things.shown(obj)
    moved = max(np.abs(after[kind] - before[kind]).max() for kind in before)
    along_a_line = max(shape) == np.prod(shape)
    assert moved > 0.02 or (along_a_line and name in ("Taper", "Twist"))
    overlay = scenes.part("tool.overlay_geometry")
    isolines = scenes.part("core.isolines")
    (shown,) = overlay.shown([(obj, modifier)], bpy.context.evaluated_depsgraph_get(), isolines.Wanted())
    assert np.isfinite(shown.drawing.isolines).all()
    assert len(shown.drawing.points) == np.prod(shape)
    assert len(shown.drawing.lattice) == 2 * sum((count - 1) * np.prod(shape) // count for count in shape)


def test_the_panel_numbers_fit_again_and_rest(made):
    obj, modifier, lattice, before, shape = made
    scenes.choose(obj)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert bpy.ops.isochor.clear_rest() == {"FINISHED"}
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert points_of(lattice) == shape
    for name, points in things.shown(obj).items():
        assert np.abs(points - before[name]).max() < 3e-6
    assert scenes.report(obj, modifier).vertices_outside == 0


def test_as_many_layers_as_asked_for_where_flat_is_off():
    grid_mesh()
    bpy.ops.isochor.add(flat=False)
    assert points_of(bpy.data.objects["Sheet Lattice"]) == (4, 4, 4)


def test_selected_vertices_in_one_plane_of_a_solid_get_all_layers():
    ball = scenes.sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    ring = scenes.positions(ball.data)[:24]
    flat = np.abs(ring[:, 2] - ring[0, 2]) < 1e-3
    for index in np.flatnonzero(flat):
        ball.data.vertices[index].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.isochor.add()
    bpy.ops.object.mode_set(mode="OBJECT")
    modifier = ball.modifiers.active
    assert points_of(scenes.get_input(modifier, "Lattice")) == (4, 4, 4)
    assert scenes.get_input(modifier, "Preserve") == 1.0


def test_a_sheet_made_thick_by_a_modifier_above_keeps_its_volume():
    sheet = grid_mesh()
    sheet.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.1
    bpy.ops.isochor.add()
    modifier = sheet.modifiers.active
    assert points_of(scenes.get_input(modifier, "Lattice")) == (4, 4, 4)
    scenes.set_input(modifier, "Squash", 0.5)
    bpy.context.view_layer.update()
    assert scenes.report(sheet, modifier).volumes.error < 1e-6
