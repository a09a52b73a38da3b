# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of pins: undo, saving, copying, other vertices, other hands; how they are bound and taken away."""

import bmesh
import bpy
import numpy as np
import other_blender
import pin_scenes
import pytest
import scenes
from mathutils import Vector
from pin_scenes import EXACT, FAR, NEAR, holds, in_world, keeps_volume, move, pin, place, squashed_ball

SCRIPT = """
import numpy as np
import pin_scenes
bpy.ops.wm.open_mainfile(filepath=arguments[0])
bpy.context.scene.frame_set(bpy.context.scene.frame_current)
ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Handle"]
assert pin_scenes.holds(ball, empty, pin_scenes.NEAR)
pin_scenes.move(empty, 0.0, 0.2, -0.2)
assert pin_scenes.holds(ball, empty, pin_scenes.NEAR)
assert pin_scenes.keeps_volume(ball)
"""


def test_saving_renaming_and_loading_in_another_blender(tmp_path):
    ball, modifier = squashed_ball()
    (empty,) = pin(ball, NEAR)
    move(empty, 0.2, 0.1, 0.2)
    empty.name, modifier.name = "Handle", "Squash"
    scenes.get_input(modifier, "Pins").name = "Handles"
    place_of_file = tmp_path / "pins.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(place_of_file), check_existing=False)
    other_blender.run(SCRIPT, tmp_path / "other", place_of_file, with_extension=True)


def test_adding_moving_and_removing_are_one_undo_step_each():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    flags = np.isin(np.arange(len(ball.data.vertices)), (NEAR, FAR))
    ball.data.vertices.foreach_set("select", flags)
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.add_pin("EXEC_DEFAULT", True)
    assert "Ball Pins" in bpy.data.collections
    bpy.ops.ed.undo()
    assert "Ball Pins" not in bpy.data.collections
    assert not [obj for obj in bpy.data.objects if obj.type == "EMPTY"]
    bpy.ops.ed.redo()
    bpy.context.view_layer.update()
    ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Ball Pin"]
    at_first = place(empty)
    move(empty, 0.3, 0.0, 0.0)
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Ball Pin"]
    assert np.allclose(place(empty), at_first)
    assert min(np.linalg.norm(in_world(ball)[[NEAR, FAR]] - at_first, axis=1)) <= EXACT
    scenes.choose(ball)
    bpy.ops.isochor.remove_pins("EXEC_DEFAULT", True)
    assert "Ball Pins" not in bpy.data.collections
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Ball Pin"]
    move(empty, 0.0, 0.2, 0.0)
    assert min(np.linalg.norm(in_world(ball)[[NEAR, FAR]] - place(empty), axis=1)) <= EXACT


def test_adding_in_edit_mode_takes_the_selected_vertices_and_leaves_the_mode():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(ball.data)
    edited.verts.ensure_lookup_table()
    edited.verts[NEAR].select_set(True)
    bmesh.update_edit_mesh(ball.data)
    assert bpy.ops.isochor.add_pin() == {"FINISHED"}
    assert ball.mode == "OBJECT"
    empty = bpy.context.view_layer.objects.active
    assert empty.type == "EMPTY"
    assert empty.select_get()
    assert not ball.select_get()
    move(empty, 0.1, 0.1, 0.1)
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)


def test_adding_in_edit_mode_is_one_undo_step():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
    bpy.ops.mesh.select_all("EXEC_DEFAULT", True, action="DESELECT")
    edited = bmesh.from_edit_mesh(ball.data)
    edited.verts.ensure_lookup_table()
    edited.verts[NEAR].select_set(True)
    bmesh.update_edit_mesh(ball.data)
    bpy.ops.ed.undo_push(message="selected")
    assert bpy.ops.isochor.add_pin("EXEC_DEFAULT", True) == {"FINISHED"}
    bpy.ops.ed.undo()
    assert bpy.data.objects["Ball"].mode == "EDIT"
    assert "Ball Pins" not in bpy.data.collections
    bpy.ops.ed.redo()
    ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Ball Pin"]
    assert ball.mode == "OBJECT"
    move(empty, 0.1, 0.0, 0.1)
    assert holds(ball, empty, NEAR)


def test_faces_are_pinned_in_their_middle():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    ball.data.polygons.foreach_set("select", np.arange(len(ball.data.polygons)) == 77)
    corners = list(ball.data.polygons[77].vertices)
    assert bpy.ops.isochor.add_pin() == {"FINISHED"}
    empty = bpy.context.view_layer.objects.active
    for way in ((0.0, 0.0, 0.0), (0.2, 0.3, -0.1)):
        move(empty, *way)
        middle = in_world(ball)[corners].mean(axis=0)
        assert np.linalg.norm(middle - place(empty)) <= EXACT
    assert keeps_volume(ball)


def surface_has(ball: bpy.types.Object, point: np.ndarray) -> float:
    """How far the drawn surface is from a point in the world."""
    shown = ball.evaluated_get(bpy.context.evaluated_depsgraph_get())
    found, near, *_ = shown.closest_point_on_mesh(shown.matrix_world.inverted() @ Vector(point))
    assert found
    return float(np.linalg.norm(np.array(shown.matrix_world @ near) - point))


def test_a_point_of_a_face_and_a_vertex_are_held_together():
    ball, modifier = squashed_ball()
    scenes.choose(ball)
    point = in_world(ball)[list(ball.data.polygons[300].vertices)].T @ (0.2, 0.5, 0.3)
    assert bpy.ops.isochor.add_pin(where="POINT", point=point) == {"FINISHED"}
    on_face = bpy.context.view_layer.objects.active
    assert np.linalg.norm(place(on_face) - point) <= EXACT
    (on_vertex,) = pin(ball, NEAR)
    for empty, way in ((on_face, (0.1, 0.2, 0.1)), (on_vertex, (0.0, -0.2, 0.3))):
        move(empty, *way)
        assert holds(ball, on_vertex, NEAR)
        corners = in_world(ball)[list(ball.data.polygons[300].vertices)]
        assert np.linalg.norm(corners.T @ (0.2, 0.5, 0.3) - place(on_face)) <= EXACT
    assert keeps_volume(ball)
    assert scenes.report(ball, modifier).largest_miss <= EXACT


def test_snapping_takes_the_nearest_vertex():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    point = in_world(ball)[NEAR] + (0.01, 0.0, 0.005)
    assert bpy.ops.isochor.add_pin(where="POINT", point=point, snap=True) == {"FINISHED"}
    empty = bpy.context.view_layer.objects.active
    move(empty, 0.1, 0.0, 0.0)
    assert holds(ball, empty, NEAR)


def test_a_line_of_sight_meets_the_deformed_surface():
    ball, _ = squashed_ball()
    ball.location.y = 0.2
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    first_hit = scenes.part("ui.picking").first_hit
    origin, direction = Vector((0.0, -5.0, 0.1)), Vector((0.0, 1.0, 0.0))
    found = first_hit([ball], origin, direction, depsgraph)
    assert surface_has(ball, found) <= EXACT
    assert found[1] < 0.0
    assert first_hit([ball], origin, -direction, depsgraph) is None


def test_a_copy_of_the_object_is_held_by_the_same_empty():
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    twin = ball.copy()
    bpy.context.scene.collection.objects.link(twin)
    bpy.context.view_layer.update()
    move(empty, 0.2, 0.0, 0.3)
    for obj in (ball, twin):
        assert holds(obj, empty, NEAR)
        assert keeps_volume(obj)


def test_other_vertices_are_said_and_the_pin_is_bound_again_where_it_was():
    ball, modifier = squashed_ball()
    (empty,) = pin(ball, NEAR)
    move(empty, 0.3, 0.0, 0.1)
    held = in_world(ball)[NEAR].copy()
    scenes.choose(ball)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert f"“{empty.name}”: bound when the mesh had other vertices" in pin_scenes.problems(ball, modifier)
    assert np.linalg.norm(in_world(ball)[NEAR] - held) > 0.05
    scenes.choose(ball)
    assert bpy.ops.isochor.bind_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert "bound when" not in pin_scenes.problems(ball, modifier)
    assert np.linalg.norm(in_world(ball)[NEAR] - held) <= EXACT
    with pytest.raises(RuntimeError, match="No pin needs to be bound"):
        bpy.ops.isochor.bind_pins()


def test_objects_of_any_kind_are_bound_where_they_stand():
    ball, modifier = squashed_ball()
    empty = scenes.linked(bpy.data.objects.new("Far Off", None))
    empty.location, empty.scale, empty.rotation_euler = (0.0, 0.0, 2.0), (0.5, 2.0, 1.0), (0.3, 0.2, 0.1)
    cube = scenes.mesh_object("Cube", [(0, 0, 0), (0, 0, 0.1), (0, 0.1, 0)], [(0, 1, 2)])
    cube.location = (1.6, 0.2, 0.1)
    bpy.context.view_layer.update()
    before = in_world(ball)
    scenes.choose(ball)
    empty.select_set(True)
    cube.select_set(True)
    assert bpy.ops.isochor.bind_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert {obj.name for obj in scenes.get_input(modifier, "Pins").all_objects} == {"Far Off", "Cube"}
    assert np.abs(in_world(ball) - before).max() <= EXACT
    top = before[np.argmax(before[:, 2])]
    move(empty, 0.1, 0.0, 0.2)
    assert surface_has(ball, top + (0.1, 0.0, 0.2)) <= 2e-2
    move(cube, 0.2, 0.0, 0.0)
    assert scenes.report(ball, modifier).largest_miss <= EXACT
    assert keeps_volume(ball)


def test_objects_put_into_the_collection_by_hand_do_nothing_until_they_are_bound():
    ball, modifier = squashed_ball()
    (empty,) = pin(ball, NEAR)
    stranger = bpy.data.objects.new("Stranger", None)
    scenes.get_input(modifier, "Pins").objects.link(stranger)
    bpy.context.view_layer.update()
    assert "“Stranger”: not bound" in pin_scenes.problems(ball, modifier)
    move(stranger, 0.0, 0.0, 2.0)
    move(empty, 0.1, 0.1, 0.1)
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)
    scenes.choose(ball)
    assert bpy.ops.isochor.bind_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems == ()


def test_the_object_in_its_own_collection_is_said():
    ball, modifier = squashed_ball()
    (empty,) = pin(ball, NEAR)
    scenes.get_input(modifier, "Pins").objects.link(ball)
    move(empty, 0.1, 0.0, 0.1)
    assert "“Ball” is in its own collection of pins" in pin_scenes.problems(ball, modifier)
    assert holds(ball, empty, NEAR)


def test_removing_takes_the_chosen_ones_and_then_the_collection():
    ball, modifier = squashed_ball()
    before = scenes.evaluated_positions(ball)
    first, second = pin(ball, NEAR, FAR)
    handle = scenes.linked(bpy.data.objects.new("Handle", None))
    scenes.choose(ball)
    handle.select_set(True)
    bpy.ops.isochor.bind_pins()
    move(second, 0.2, 0.2, 0.2)
    scenes.choose(ball)
    first.select_set(True)
    assert bpy.ops.isochor.remove_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert len(scenes.get_input(modifier, "Pins").all_objects) == 2
    assert holds(ball, second, FAR)
    scenes.choose(ball)
    assert bpy.ops.isochor.remove_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert [obj.name for obj in bpy.data.objects if obj.type == "EMPTY"] == ["Handle"]
    assert "Handle" in bpy.context.scene.objects
    assert not handle.keys()
    assert "Ball Pins" not in bpy.data.collections
    assert np.abs(scenes.evaluated_positions(ball) - before).max() <= EXACT
    with pytest.raises(RuntimeError, match="no pins to remove"):
        bpy.ops.isochor.remove_pins()


def test_pins_are_added_to_a_collection_that_is_excluded_or_in_no_scene():
    ball, modifier = squashed_ball()
    scenes.set_input(modifier, "Pins", bpy.data.collections.new("Hidden Away"))
    (empty,) = pin(ball, NEAR)
    assert bpy.context.view_layer.objects.active == ball
    move(empty, 0.2, 0.0, 0.1)
    assert holds(ball, empty, NEAR)


def test_an_empty_without_a_place_or_a_size_is_told():
    ball, modifier = squashed_ball()
    first, second = pin(ball, NEAR, FAR)
    first.location.x = float("nan")
    bpy.context.view_layer.update()
    assert f"“{first.name}”: stands nowhere" in pin_scenes.problems(ball, modifier)
    assert holds(ball, second, FAR)
    second.scale = (1.0, 0.0, 1.0)
    bpy.context.view_layer.update()
    assert holds(ball, second, FAR)
    scenes.choose(ball)
    second.select_set(True)
    with pytest.raises(RuntimeError, match="has a scale of zero, so it can hold nothing"):
        bpy.ops.isochor.bind_pins()


def test_removing_the_modifier_takes_its_pins_along():
    ball, _ = squashed_ball()
    pin(ball, NEAR)
    scenes.choose(ball)
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not [obj for obj in bpy.data.objects if obj.type == "EMPTY"]
    assert "Ball Pins" not in bpy.data.collections


def test_a_selected_pin_stands_for_its_mesh():
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    scenes.choose(empty)
    assert bpy.ops.isochor.remove_pins() == {"FINISHED"}
    assert not [obj for obj in bpy.data.objects if obj.type == "EMPTY"]
    assert bpy.context.view_layer.objects.active == ball


def test_what_cannot_be_pinned_is_refused():
    ball, modifier = squashed_ball()
    scenes.choose(ball)
    ball.data.vertices.foreach_set("select", np.zeros(len(ball.data.vertices), bool))
    with pytest.raises(RuntimeError, match="Nothing is selected to pin"):
        bpy.ops.isochor.add_pin()
    ball.data.vertices.foreach_set("select", np.ones(len(ball.data.vertices), bool))
    with pytest.raises(RuntimeError, match="the lattice has 125"):
        bpy.ops.isochor.add_pin()
    modifier.show_viewport = False
    scenes.part("tool.state").clear()
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="shows no computed shape"):
        bpy.ops.isochor.add_pin(where="POINT")
    assert "Ball Pins" not in bpy.data.collections
    scenes.empty_file()
    assert not bpy.ops.isochor.add_pin.poll()
    assert not bpy.ops.isochor.bind_pins.poll()
    assert not bpy.ops.isochor.remove_pins.poll()


def test_linked_objects_are_refused_and_held_as_they_were_saved(tmp_path):
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    move(empty, 0.2, 0.0, 0.2)
    shape = scenes.evaluated_positions(ball)
    library = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(library), check_existing=False)
    scenes.empty_file()
    with bpy.data.libraries.load(str(library), link=True) as (_there, here):
        here.objects = ["Ball"]
    linked = scenes.linked(here.objects[0])
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(linked) - shape).max() <= EXACT
    with pytest.raises(RuntimeError, match="comes from another file"):
        bpy.ops.isochor.add_pin(where="POINT")


def test_appended_object_brings_its_pins(tmp_path):
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    library = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(library), check_existing=False)
    scenes.empty_file()
    with bpy.data.libraries.load(str(library), link=False) as (_there, here):
        here.objects = ["Ball"]
    ball = scenes.linked(here.objects[0])
    bpy.context.view_layer.update()
    empty = bpy.data.objects["Ball Pin"]
    move(empty, 0.1, 0.2, 0.1)
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)


def test_a_library_override_is_held_by_its_own_empties(tmp_path):
    ball, _ = squashed_ball()
    pin(ball, NEAR)
    character = bpy.data.collections.new("Character")
    for obj in (ball, bpy.data.objects["Ball Cage"]):
        bpy.context.scene.collection.objects.unlink(obj)
        character.objects.link(obj)
    held = bpy.data.collections["Ball Pins"]
    bpy.context.scene.collection.children.unlink(held)
    character.children.link(held)
    bpy.context.scene.collection.children.link(character)
    library = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(library), check_existing=False)
    scenes.empty_file()
    with bpy.data.libraries.load(str(library), link=True) as (_there, here):
        here.collections = ["Character"]
    scene, layer = bpy.context.scene, bpy.context.view_layer
    own = here.collections[0].override_hierarchy_create(scene, layer, do_fully_editable=True)
    bpy.context.view_layer.update()
    ball, empty = (next(obj for obj in own.all_objects if obj.type == kind) for kind in ("MESH", "EMPTY"))
    for height in (0.2, 0.3):
        move(empty, 0.0, 0.1, height)
        assert holds(ball, empty, NEAR)
        assert keeps_volume(ball)
    scenes.choose(ball)
    empty.select_set(True)
    with pytest.raises(RuntimeError, match="comes from another file"):
        bpy.ops.isochor.bind_pins()
