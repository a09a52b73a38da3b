# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.fit_lattice: the box fits again after modelling, and what the animator made of the points stays."""

import bmesh
import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler

RNG = np.random.default_rng(5)


def added(resolution=(4, 4, 4), **properties) -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.NodesModifier]:
    ball = scenes.sphere()
    assert bpy.ops.isochor.add(resolution=resolution, **properties) == {"FINISHED"}
    modifier = ball.modifiers[0]
    return ball, scenes.get_input(modifier, "Lattice"), modifier


def shake(lattice: bpy.types.Object) -> None:
    for point in lattice.data.points:
        point.co_deform = [place + RNG.normal(0.0, 0.06) for place in point.co_deform]
    bpy.context.view_layer.update()


def model(obj: bpy.types.Object, change) -> None:
    """Edits the mesh: ``change`` takes and gives (V, 3)."""
    found = change(scenes.positions(obj.data)).astype(np.float32)
    obj.data.attributes["position"].data.foreach_set("vector", found.reshape(-1))
    obj.data.update()
    bpy.context.view_layer.update()


def points(lattice: bpy.types.Object) -> np.ndarray:
    found = np.empty(len(lattice.data.points) * 3, np.float32)
    lattice.data.points.foreach_get("co_deform", found)
    return found.reshape(-1, 3)


def in_lattice(obj: bpy.types.Object, lattice: bpy.types.Object, found: np.ndarray | None = None) -> np.ndarray:
    """Vertices where the undeformed lattice is the unit cube about the origin."""
    matrix = np.linalg.inv(np.array(lattice.matrix_world)) @ np.array(obj.matrix_world)
    found = scenes.positions(obj.data) if found is None else found
    return found @ matrix[:3, :3].T + matrix[:3, 3]


def fits(inside: np.ndarray, margin: float = 0.05) -> bool:
    half = 0.5 / (1.0 + 2.0 * margin)
    return np.allclose(inside.max(axis=0), half, atol=2e-5) and np.allclose(inside.min(axis=0), -half, atol=2e-5)


def refused(**properties) -> str:
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.isochor.fit_lattice(**properties)
    return str(caught.value)


def test_after_modelling_the_box_fits_the_deformation_stays_and_the_problem_is_gone():
    ball, lattice, modifier = added()
    shake(lattice)
    shape, before = points(lattice), in_lattice(ball, lattice, scenes.evaluated_positions(ball))
    model(ball, lambda found: found * (2.0, 1.0, 0.8) + (3.0, 0.0, 1.0))
    assert any("was edited" in text for text in scenes.report(ball, modifier).problems)
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert fits(in_lattice(ball, lattice))
    assert np.array_equal(points(lattice), shape)
    assert scenes.report(ball, modifier).problems == ()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    # The mesh was stretched like the box, so in the box it is deformed just as before.
    scenes.set_input(modifier, "Space", "Lattice")
    bpy.context.view_layer.update()
    after = in_lattice(ball, lattice, scenes.evaluated_positions(ball))
    assert np.abs(before - in_lattice(ball, lattice)).max() > 0.02
    assert np.abs(after - before).max() < 0.02


def test_without_correction_the_deformation_in_the_box_is_exactly_the_same():
    ball, lattice, modifier = added()
    shake(lattice)
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    before = in_lattice(ball, lattice, scenes.evaluated_positions(ball))
    model(ball, lambda found: found * (2.0, 1.0, 0.5) + (3.0, 0.0, 1.0))
    bpy.ops.isochor.fit_lattice()
    assert np.abs(in_lattice(ball, lattice, scenes.evaluated_positions(ball)) - before).max() < 5e-6


@pytest.mark.parametrize("fit", ["KEEP", "LOCAL", "ORIENTED", "WORLD"])
def test_all_users_fit_together_along_the_axes_asked_for(fit):
    first, second = scenes.sphere(name="First"), scenes.sphere(name="Second")
    first.rotation_euler = (0.3, 0.2, 0.5)
    second.location = (4.0, 1.0, 0.0)
    scenes.choose(first)
    second.select_set(True)
    bpy.context.view_layer.update()
    bpy.ops.isochor.add(resolution=(3, 4, 5))
    lattice = scenes.get_input(first.modifiers[0], "Lattice")
    lattice.rotation_euler = (0.1, -0.4, 0.9)
    bpy.context.view_layer.update()
    rotation = lattice.matrix_world.to_quaternion()
    model(first, lambda found: found * 1.7)
    scenes.choose(lattice)
    assert bpy.ops.isochor.fit_lattice(fit=fit, margin=0.1) == {"FINISHED"}
    inside = np.concatenate([in_lattice(obj, lattice) for obj in (first, second)])
    assert fits(inside, 0.1)
    turned = lattice.matrix_world.to_quaternion()
    wanted = {"KEEP": rotation, "WORLD": Euler().to_quaternion(), "LOCAL": first.matrix_world.to_quaternion()}
    if fit in wanted:
        assert abs(turned.rotation_difference(wanted[fit]).angle) < 1e-5
    assert not any(scenes.report(obj, obj.modifiers[0]).problems for obj in (first, second))


def test_bspline_box_stays_one_layer_larger():
    ball, lattice, modifier = added(resolution=(6, 6, 6), basis="BSPLINE", margin=0.0)
    model(ball, lambda found: found * 1.5)
    bpy.ops.isochor.fit_lattice(margin=0.0)
    inside = in_lattice(ball, lattice) * 5.0
    assert np.abs(np.abs(inside).max(axis=0) - 1.5).max() < 1e-4
    assert scenes.report(ball, modifier).vertices_outside == 0


def test_what_enters_counts_not_the_mesh_and_not_what_leaves():
    ball, lattice, _ = added()
    ball.modifiers.new("Displace", "DISPLACE").strength = 0.7
    ball.modifiers.move(1, 0)
    shake(lattice)
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    for modifier in ball.modifiers:
        modifier.show_viewport = modifier.type == "DISPLACE"
    bpy.context.view_layer.update()
    assert fits(in_lattice(ball, lattice, scenes.evaluated_positions(ball)))


def test_a_render_with_another_subdivision_has_its_own_rest_volume():
    ball, lattice, modifier = added()
    subdivision = ball.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 2
    ball.modifiers.move(1, 0)
    model(ball, lambda found: found * 1.3)
    bpy.ops.isochor.fit_lattice()
    kept = [scenes.get_input(modifier, name)["isochor_rest_volume"] for name in ("Viewport Result", "Render Result")]
    modifier.show_viewport = False
    for level, volume in zip((1, 2), kept, strict=True):
        subdivision.levels = level
        bpy.context.view_layer.update()
        assert abs(scenes.evaluated_volume(ball) / volume - 1) <= 1e-6
    assert abs(kept[0] / kept[1] - 1) > 1e-4
    assert lattice.type == "LATTICE"


def test_in_edit_mode_of_the_mesh_and_of_the_lattice():
    ball, lattice, modifier = added()
    shake(lattice)
    scenes.choose(ball)
    bpy.ops.object.mode_set(mode="EDIT")
    mesh = bmesh.from_edit_mesh(ball.data)
    for vertex in mesh.verts:
        vertex.co *= 1.5
    bmesh.update_edit_mesh(ball.data)
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert fits(in_lattice(ball, lattice))
    assert scenes.report(ball, modifier).problems == ()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    model(ball, lambda found: found * 1.2)
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert fits(in_lattice(ball, lattice))
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_parented_lattice_stays_parented_and_fits():
    ball, lattice, _ = added()
    handle = bpy.data.objects.new("Handle", None)
    bpy.context.scene.collection.objects.link(handle)
    handle.location, handle.rotation_euler, handle.scale = (1.0, 2.0, 3.0), (0.3, 0.1, 0.7), (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    lattice.parent = handle
    lattice.matrix_parent_inverse = handle.matrix_world.inverted()
    lattice.delta_location.x = 0.5
    bpy.context.view_layer.update()
    model(ball, lambda found: found * 0.6 + (0.0, 0.0, 2.0))
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert fits(in_lattice(ball, lattice))
    assert lattice.parent == handle
    handle.scale = (2.0, 1.0, 0.3)
    bpy.context.view_layer.update()
    place = np.array(lattice.matrix_world)
    assert "The parent of “Ball Lattice” skews it" in refused()
    assert np.allclose(np.array(lattice.matrix_world), place, atol=1e-6)


def test_several_lattices_are_fitted_together_or_not_at_all():
    first, one, _ = added()
    second = scenes.sphere(name="Second")
    bpy.ops.isochor.add()
    other = scenes.get_input(second.modifiers[0], "Lattice")
    for obj in (first, second):
        model(obj, lambda found: found * 1.4)
    first.select_set(True)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (1.0, 2.0, 0.5)
    other.parent = parent
    other.rotation_euler.x = 0.5
    bpy.context.view_layer.update()
    places = [np.array(lattice.matrix_world) for lattice in (one, other)]
    assert "The parent of “Second Lattice” skews it" in refused()
    for lattice, place in zip((one, other), places, strict=True):
        assert np.allclose(np.array(lattice.matrix_world), place, atol=1e-6)
    assert scenes.report(first, first.modifiers[0]).problems
    parent.scale = (1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert fits(in_lattice(first, one))
    assert fits(in_lattice(second, other))
    assert not scenes.report(first, first.modifiers[0]).problems


@pytest.mark.parametrize("resolution", [(6, 4, 5), (0, 7, 0), (9, 9, 9)])
def test_more_points_deform_exactly_as_the_fewer_did(resolution):
    ball, lattice, modifier = added(resolution=(4, 3, 2))
    shake(lattice)
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    before = scenes.evaluated_positions(ball)
    assert bpy.ops.isochor.fit_lattice(resolution=resolution) == {"FINISHED"}
    bpy.context.view_layer.update()
    wanted = tuple(new or old for new, old in zip(resolution, (4, 3, 2), strict=True))
    assert (lattice.data.points_u, lattice.data.points_v, lattice.data.points_w) == wanted
    assert np.abs(before - scenes.positions(ball.data)).max() > 0.02
    assert np.abs(scenes.evaluated_positions(ball) - before).max() < 5e-6
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_a_lattice_of_one_layer_gets_more_with_the_same_deformation():
    ball, lattice, modifier = added(resolution=(3, 4, 2))
    lattice.data.points_w = 1
    shake(lattice)
    scenes.set_input(modifier, "Preserve", 0.0)
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    bpy.context.view_layer.update()
    before = scenes.evaluated_positions(ball)
    assert bpy.ops.isochor.fit_lattice(resolution=(3, 5, 4)) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert lattice.data.points_w == 4
    assert np.abs(before - scenes.positions(ball.data)).max() > 0.02
    assert np.abs(scenes.evaluated_positions(ball) - before).max() < 5e-6


def test_a_resolution_that_would_change_the_deformation_is_refused():
    ball, lattice, modifier = added()
    place = np.array(lattice.matrix_world)
    model(ball, lambda found: found * 1.4)
    assert "“Ball Lattice” has 4 points along Y; 3 would deform otherwise" in refused(resolution=(5, 3, 4))
    scenes.set_input(modifier, "Basis", "B-Spline")
    assert "The same with 5, 6, 7 … points" in refused(resolution=(3, 5, 5))
    scenes.set_input(modifier, "Basis", "Bernstein")
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    assert "is in Edit Mode" in refused(resolution=(5, 5, 5))
    bpy.ops.object.mode_set(mode="OBJECT")
    lattice.shape_key_add(name="Basis")
    lattice.data.use_outside = True
    assert "has Outside on" in refused(resolution=(5, 5, 5))
    assert np.array_equal(np.array(lattice.matrix_world), place)
    assert len(lattice.data.points) == 64
    assert bpy.ops.isochor.fit_lattice(resolution=(4, 4, 0)) == {"FINISHED"}


def test_a_mirrored_lattice_keeps_its_deformation():
    ball, lattice, modifier = added()
    lattice.scale.x *= -1.0
    scenes.set_input(modifier, "Preserve", 0.0)
    shake(lattice)
    before = in_lattice(ball, lattice, scenes.evaluated_positions(ball))
    model(ball, lambda found: found * 1.4)
    bpy.ops.isochor.fit_lattice()
    assert np.abs(in_lattice(ball, lattice, scenes.evaluated_positions(ball)) - before).max() < 5e-6


def test_one_undo_step():
    ball, lattice, _ = added()
    model(ball, lambda found: found * 1.4)
    place = np.array(lattice.matrix_world)
    volume = scenes.get_input(ball.modifiers[0], "Viewport Result")["isochor_rest_volume"]
    bpy.ops.ed.undo_push(message="modelled")
    bpy.ops.isochor.fit_lattice("EXEC_DEFAULT", True)
    assert not np.allclose(np.array(lattice.matrix_world), place)
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    ball, lattice = bpy.data.objects["Ball"], bpy.data.objects["Ball Lattice"]
    assert np.allclose(np.array(lattice.matrix_world), place)
    assert scenes.get_input(ball.modifiers[0], "Viewport Result")["isochor_rest_volume"] == volume
    bpy.ops.ed.redo()
    bpy.context.view_layer.update()
    assert fits(in_lattice(bpy.data.objects["Ball"], bpy.data.objects["Ball Lattice"]))
    assert not scenes.report(bpy.data.objects["Ball"], bpy.data.objects["Ball"].modifiers[0]).problems


def test_refusals_in_plain_words_change_nothing():
    ball, lattice, modifier = added()
    model(ball, lambda found: found * 1.4)
    place = np.array(lattice.matrix_world)
    lattice.keyframe_insert("location", frame=1)
    assert "The transform of “Ball Lattice” is animated (location)" in refused()
    lattice.animation_data_clear()
    lattice.driver_add("delta_scale", 1).driver.expression = "frame"
    assert "is animated (delta_scale)" in refused()
    lattice.animation_data_clear()
    lattice.delta_scale = (1.0, 1.0, 1.0)
    track = lattice.constraints.new("COPY_LOCATION")
    track.target = bpy.data.objects.new("Goal", None)
    assert "is held by constraints (Copy Location)" in refused()
    track.enabled = False
    lattice.modifiers.new("Hook", "HOOK")
    assert "has modifiers (Hook) that would not move with it" in refused()
    lattice.modifiers.clear()
    bpy.context.view_layer.update()
    assert np.allclose(np.array(lattice.matrix_world), place)
    scenes.set_input(modifier, "Lattice", None)
    assert "No lattice" in refused()
    bpy.ops.isochor.remove()
    assert not bpy.ops.isochor.fit_lattice.poll()


def test_a_mesh_whose_rest_was_set_is_refused_until_that_is_cleared():
    ball, lattice, _ = added()
    bpy.ops.isochor.set_rest()
    model(ball, lambda found: found * 1.4)
    place = np.array(lattice.matrix_world)
    assert "Ball: the rest with “Ball Lattice” was set" in refused()
    assert np.array_equal(np.array(lattice.matrix_world), place)
    bpy.ops.isochor.clear_rest()
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert fits(in_lattice(ball, lattice))


def test_a_mesh_of_another_file_is_refused(tmp_path):
    added()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    scenes.linked(wanted.objects[0])
    assert "comes from another file" in refused()
