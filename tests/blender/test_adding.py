# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.add and isochor.remove, as an animator meets them."""

import bmesh
import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix


def lattice_of(obj: bpy.types.Object) -> bpy.types.Object:
    return scenes.get_input(obj.modifiers.active, "Lattice")


def in_lattice(obj: bpy.types.Object, lattice: bpy.types.Object) -> np.ndarray:
    """The object's vertices in lattice space, where the undeformed lattice is the unit cube about the origin."""
    matrix = np.linalg.inv(np.array(lattice.matrix_world)) @ np.array(obj.matrix_world)
    return scenes.positions(obj.data) @ matrix[:3, :3].T + matrix[:3, 3]


def test_add_makes_a_fitting_lattice_a_modifier_and_no_difference():
    ball = scenes.sphere()
    assert bpy.ops.isochor.add() == {"FINISHED"}
    modifier = ball.modifiers[0]
    lattice = lattice_of(ball)
    assert (modifier.name, modifier.type) == ("Volume Lattice", "NODES")
    assert lattice.type == "LATTICE"
    assert lattice.name in bpy.context.scene.objects
    assert (lattice.data.points_u, lattice.data.points_v, lattice.data.points_w) == (4, 4, 4)
    inside = in_lattice(ball, lattice)
    assert np.allclose(inside.max(axis=0), 0.5 / 1.1, atol=1e-5)
    assert np.allclose(inside.min(axis=0), -0.5 / 1.1, atol=1e-5)
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 1e-6
    assert bpy.context.view_layer.objects.active == ball
    assert bpy.context.scene.render.use_lock_interface


def test_sockets_have_the_names_and_panels_that_were_agreed():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    items = ball.modifiers[0].node_group.interface.items_tree
    inputs = [item for item in items if item.item_type == "SOCKET" and item.in_out == "INPUT"]
    shown = {}
    for item in inputs:
        if not item.hide_in_modifier and item.socket_type != "NodeSocketGeometry":
            shown.setdefault(item.parent.name, []).append(item.name)
    assert shown == {
        "": ["Lattice", "Strength", "Vertex Group", "Invert"],
        "Volume": [
            *("Preserve", "Reference", "Target", "Axes", "Space", "Frame", "Method", "Cost", "Stiffness", "Where Lost"),
            *("Islands", "Region", "Region Target", "Close Holes", "Unfolded"),
        ],
        "Pins": ["Pins", "Falloff"],
        "Animate": ["Axis", "Squash", "Taper", "Twist", "Bend", "Bend Direction", "Pivot"],
        "Interpolation": ["Basis", "Outside", "Weights", "Heaviest", "Joint"],
    }
    assert list(shown) == ["", "Volume", "Pins", "Animate", "Interpolation"]
    defaults = {name: scenes.get_input(ball.modifiers[0], name) for name in ("Preserve", "Reference", "Target")}
    assert defaults == {"Preserve": 1.0, "Reference": "Rest", "Target": 1.0}
    assert tuple(scenes.get_input(ball.modifiers[0], "Axes")) == (1.0, 1.0, 1.0)
    menus = {name: scenes.get_input(ball.modifiers[0], name) for name in ("Space", "Method", "Basis", "Outside")}
    assert menus == {"Space": "Global", "Method": "Balanced", "Basis": "Bernstein", "Outside": "Keep"}


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender 4.5 does not tell which inputs it greys out")
def test_no_input_is_greyed_out():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    modifier = ball.modifiers[0]
    for item in modifier.node_group.interface.items_tree:
        if (
            item.item_type == "SOCKET"
            and item.in_out == "INPUT"
            and not item.hide_in_modifier
            and item.name != "Invert"
        ):
            assert modifier.is_input_used(item.identifier), item.name


def test_bspline_lattice_is_one_layer_larger_and_reaches_every_vertex():
    ball = scenes.sphere()
    bpy.ops.isochor.add(resolution=(8, 6, 5), basis="BSPLINE", margin=0.0)
    lattice = lattice_of(ball)
    assert scenes.get_input(ball.modifiers[0], "Basis") == "B-Spline"
    inside = in_lattice(ball, lattice)
    for axis, points in enumerate((8, 6, 5)):
        domain = 0.5 * (points - 3) / (points - 1)
        assert np.isclose(inside[:, axis].max(), domain, atol=1e-5)
        assert np.isclose(inside[:, axis].min(), -domain, atol=1e-5)
    for point in lattice.data.points:
        point.co_deform.x += 0.25
    bpy.context.view_layer.update()
    moved = scenes.evaluated_positions(ball) - scenes.positions(ball.data)
    assert np.allclose(moved[:, 0], 0.25 * lattice.scale.x, atol=1e-5)


def test_local_fit_follows_the_object_and_world_fit_the_world():
    ball = scenes.sphere()
    ball.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((0.5, 0.2, 0.9)), (2.0, 1.0, 0.5))
    bpy.context.view_layer.update()
    bpy.ops.isochor.add(margin=0.0)
    local = lattice_of(ball)
    assert np.allclose(np.array(local.rotation_euler.to_matrix()), np.array(ball.rotation_euler.to_matrix()), atol=1e-5)
    assert np.allclose(np.abs(in_lattice(ball, local)).max(axis=0), 0.5, atol=1e-5)
    bpy.ops.isochor.remove()
    bpy.ops.isochor.add(fit="WORLD", margin=0.0)
    world = lattice_of(ball)
    assert np.allclose(np.array(world.rotation_euler), 0.0)
    assert np.allclose(np.abs(in_lattice(ball, world)).max(axis=0), 0.5, atol=1e-5)


@pytest.mark.parametrize("turn", [(0.5, 0.2, 0.9), (1.1, -0.7, 2.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("size", [(4.0, 1.0, 0.5), (3.0, 1.0, 1.0), (2.0, 2.0, 2.0), (2.0, 1.0, 0.0)])
def test_oriented_fit_finds_the_box_that_the_vertices_are_corners_of(turn, size):
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    rotation = np.array(Euler(turn).to_matrix())
    scenes.mesh_object("Plank", corners @ rotation.T + (1.0, 2.0, 3.0), [(0, 1, 3, 2), (4, 6, 7, 5)])
    plank = bpy.context.object
    bpy.ops.isochor.add(fit="ORIENTED", margin=0.0)
    lattice = lattice_of(plank)
    thinnest = 0.01 * max(size)
    assert np.allclose(sorted(lattice.scale), sorted(np.maximum(size, thinnest)), atol=1e-3)
    inside = np.abs(in_lattice(plank, lattice))
    assert np.allclose(inside[:, np.array(lattice.scale) > 2 * thinnest], 0.5, atol=1e-3)
    assert inside.max() <= 0.5


def test_oriented_fit_is_no_larger_than_the_others():
    points = np.random.default_rng(7).normal(size=(300, 3)) @ [(1.0, 0.8, 0.1), (0.0, 0.6, 0.4), (0.0, 0.0, 0.3)]
    cloud = scenes.mesh_object("Cloud", points, [(0, 1, 2)])
    volumes = {}
    for fit in ("LOCAL", "ORIENTED", "WORLD"):
        bpy.ops.isochor.add(fit=fit, margin=0.0)
        volumes[fit] = np.prod(lattice_of(cloud).scale)
        assert np.linalg.det(np.array(lattice_of(cloud).matrix_world)) > 0.0
        bpy.ops.isochor.remove()
    assert volumes["ORIENTED"] < 0.8 * volumes["LOCAL"]
    assert volumes["LOCAL"] == pytest.approx(volumes["WORLD"], rel=1e-5)


@pytest.mark.parametrize("fit", ["LOCAL", "ORIENTED", "WORLD"])
@pytest.mark.parametrize(("basis", "side"), [("BERNSTEIN", 4), ("BSPLINE", 6)])
def test_no_vertex_is_outside_a_lattice_without_margin_far_from_the_origin(fit, basis, side):
    ball = scenes.sphere()
    ball.location, ball.rotation_euler = (101.7, 0.3, -2.0), (0.4, 0.7, 1.1)
    bpy.context.view_layer.update()
    bpy.ops.isochor.add(resolution=(side, side, side), basis=basis, fit=fit, margin=0.0)
    assert scenes.report(ball, ball.modifiers[0]).vertices_outside == 0
    bpy.ops.mesh.primitive_cube_add(location=(1003.0, 0.0, 0.0))
    cube = bpy.context.object
    bpy.ops.isochor.add(resolution=(side, side, side), basis=basis, fit=fit, margin=0.0)
    assert scenes.report(cube, cube.modifiers[0]).vertices_outside == 0


def test_locking_the_interface_is_reported_once(capfd):
    scenes.sphere()
    assert not bpy.context.scene.render.use_lock_interface
    bpy.ops.isochor.add()
    assert capfd.readouterr().out.count("Lock Interface is now on") == 1
    bpy.ops.isochor.add()
    assert "Lock Interface" not in capfd.readouterr().out


def test_several_selected_objects_share_one_lattice_around_all():
    left, right = scenes.sphere(name="Left"), scenes.sphere(name="Right")
    left.location.x = -3.0
    left.select_set(True)
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.add() == {"FINISHED"}
    assert lattice_of(left) == lattice_of(right)
    for obj in (left, right):
        assert np.abs(in_lattice(obj, lattice_of(obj))).max() <= 0.5
    assert left.modifiers[0].node_group == right.modifiers[0].node_group
    assert scenes.get_input(left.modifiers[0], "Viewport Result") != scenes.get_input(
        right.modifiers[0], "Viewport Result"
    )


def test_edit_mode_fits_the_selected_vertices():
    ball = scenes.sphere()
    chosen = scenes.positions(ball.data)
    chosen = chosen[chosen[:, 2] > 0.5]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    for vertex in bmesh.from_edit_mesh(ball.data).verts:
        vertex.select_set(vertex.co.z > 0.5)
    assert bpy.ops.isochor.add(margin=0.0) == {"FINISHED"}
    lattice = lattice_of(ball)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.allclose(np.array(lattice.scale), np.ptp(chosen, axis=0), atol=1e-5)


def test_a_plane_gets_a_lattice_of_some_thickness_and_a_word_on_its_volume():
    bpy.ops.mesh.primitive_plane_add()
    plane = bpy.context.object
    assert bpy.ops.isochor.add() == {"FINISHED"}
    lattice = lattice_of(plane)
    assert lattice.scale.z > 0
    assert "hole" in scenes.report(plane, plane.modifiers[0]).problems[0]
    for point in lattice.data.points:
        point.co_deform.x *= 2.0
    bpy.context.view_layer.update()
    assert np.allclose(scenes.evaluated_positions(plane)[:, 0], 2.0 * scenes.positions(plane.data)[:, 0], atol=1e-5)


def test_remove_leaves_the_file_as_it_was():
    ball = scenes.sphere()
    kinds = ("objects", "meshes", "lattices", "node_groups")
    before = {kind: {item.name for item in getattr(bpy.data, kind)} for kind in kinds}
    attributes = [attribute.name for attribute in ball.data.attributes]
    points = scenes.positions(ball.data)
    bpy.ops.isochor.add()
    lattice_of(ball).data.points[0].co_deform.x += 1.0
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert {kind: {item.name for item in getattr(bpy.data, kind)} for kind in kinds} == before
    assert not ball.modifiers
    assert [attribute.name for attribute in ball.data.attributes] == attributes
    assert np.array_equal(scenes.evaluated_positions(ball), points)


def test_remove_spares_a_lattice_that_is_used_or_was_there_before():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    used = lattice_of(ball)
    other = scenes.sphere(name="Other")
    scenes.native_lattice(other, used)
    scenes.choose(ball)
    bpy.ops.isochor.remove()
    assert used.name in bpy.data.objects
    own = scenes.lattice_object(3)
    scenes.volume_lattice(ball, own)
    bpy.ops.isochor.remove()
    assert own.name in bpy.data.objects


def test_nothing_selected_is_refused_in_plain_words():
    assert not bpy.ops.isochor.add.poll()
    with pytest.raises(RuntimeError, match="Select a mesh object first"):
        bpy.ops.isochor.add()
    ball = scenes.sphere()
    with pytest.raises(RuntimeError, match="no Volume Lattice"):
        bpy.ops.isochor.remove()
    ball.data.vertices[3].co.z = float("nan")
    ball.data.update()
    for fit in ("LOCAL", "ORIENTED", "WORLD"):
        with pytest.raises(RuntimeError, match="have no place"):
            bpy.ops.isochor.add(fit=fit)
    ball.data.clear_geometry()
    with pytest.raises(RuntimeError, match="no vertices"):
        bpy.ops.isochor.add()


def test_menus_offer_it():
    menus = scenes.part("ui.menus")
    for name, draw in menus.PLACES:
        assert draw in getattr(bpy.types, name)._dyn_ui_initialize()


@pytest.mark.parametrize("follow", [True, False])
def test_follow_object_has_the_lattice_move_along(follow):
    ball = scenes.sphere()
    ball.location, ball.rotation_euler, ball.scale = (1.0, 2.0, 3.0), (0.3, 0.2, 0.1), (1.0, 2.0, 0.5)
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.add(follow=follow) == {"FINISHED"}
    lattice = bpy.data.objects["Ball Lattice"]
    bpy.context.view_layer.update()
    before = np.array(ball.matrix_world.inverted() @ lattice.matrix_world)
    shape = scenes.evaluated_positions(ball)
    assert np.abs(shape - scenes.positions(ball.data)).max() < 1e-6
    ball.location.x += 5.0
    ball.rotation_euler.z += 1.0
    bpy.context.view_layer.update()
    after = np.array(ball.matrix_world.inverted() @ lattice.matrix_world)
    assert np.allclose(before, after, atol=1e-5) == follow
