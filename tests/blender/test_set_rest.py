# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.set_rest and isochor.clear_rest: a lattice shaped first and bound then, and moved as a whole."""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix

Array = np.ndarray


def bent_lattice(lattice: bpy.types.Object) -> None:
    """A quarter turn from bottom to top, a little wider towards the top."""
    for point in lattice.data.points:
        x, y, z = point.co
        angle = 0.5 * np.pi * (z + 0.5) * 0.6
        wide = 1.0 + 0.3 * (z + 0.5)
        radius = 1.2 - wide * x
        point.co_deform = (1.2 - radius * np.cos(angle), wide * y, radius * np.sin(angle) - 0.5)
    bpy.context.view_layer.update()


def bound_ball(bend: bool = True, size: float = 4.5, **inputs) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball inside a lattice that was shaped first and bound then; the ball is the active object."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=size)
    scenes.volume_lattice(ball, lattice, **inputs)
    if bend:
        bent_lattice(lattice)
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    return ball, lattice


def whole_volume_kept(ball: bpy.types.Object) -> bool:
    return abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def problems(ball: bpy.types.Object) -> tuple[str, ...]:
    return scenes.report(ball, ball.modifiers[-1]).problems


def moved(points: Array, matrix: Matrix) -> Array:
    full = np.array(matrix)
    return points @ full[:3, :3].T + full[:3, 3]


def key_motion(lattice: bpy.types.Object) -> dict[int, Matrix]:
    """Keys the lattice's transform over three frames; by frame, the motion since the first in world space."""
    bpy.context.view_layer.update()
    first = lattice.matrix_world.copy()
    motions = {}
    for frame, place, turn in (
        (1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        (5, (1.0, -2.0, 0.5), (0.4, 0.0, 1.0)),
        (9, (0.0, 3.0, 1.0), (0.0, 1.5, -2.0)),
    ):
        motion = Matrix.LocRotScale(place, Euler(turn), None)
        lattice.matrix_world = motion @ first
        lattice.rotation_mode = "QUATERNION"
        for path in ("location", "rotation_quaternion"):
            lattice.keyframe_insert(path, frame=frame)
        motions[frame] = motion
    return motions


def seen(frame: int, in_render: bool) -> Array:
    bpy.context.scene.frame_set(frame)
    ball = bpy.data.objects["Ball"]
    return rendered(frame)[1] if in_render else scenes.evaluated_positions(ball)


class NotingEngine(bpy.types.RenderEngine):
    """Notes the shape that a render engine gets instead of drawing it."""

    bl_idname = "ISOCHOR_NOTING"
    bl_label = "Noting"
    noted: list[tuple[float, Array]] = []

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        mesh = depsgraph.id_eval_get(bpy.data.objects["Ball"]).data
        self.noted.append((scenes.volume(mesh), scenes.positions(mesh)))


@pytest.fixture(autouse=True)
def engine():
    """An engine that shows what renders see."""
    bpy.utils.register_class(NotingEngine)
    yield
    bpy.utils.unregister_class(NotingEngine)


def rendered(frame: int) -> tuple[float, Array]:
    """Volume and vertices of the ball as a render sees it in this frame."""
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = scenes.linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    scene.render.engine = NotingEngine.bl_idname
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.frame_set(frame)
    NotingEngine.noted.clear()
    bpy.ops.render.render()
    return NotingEngine.noted[-1]


def test_binding_a_lattice_as_it_was_added_changes_nothing():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    before = scenes.evaluated_positions(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert np.abs(scenes.evaluated_positions(ball) - before).max() < 1e-6
    assert problems(ball) == ()


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_a_lattice_shaped_first_and_bound_then_leaves_the_mesh_as_it_enters(basis):
    ball, lattice = bound_ball(Preserve=0.0, Basis=basis, size=4.5 if basis == "Bernstein" else 18.0)
    own = scenes.positions(ball.data)
    assert np.array_equal(scenes.evaluated_positions(ball), own)
    assert scenes.report(ball, ball.modifiers[0]).vertices_outside == 0
    lattice.data.points[37].co_deform.x += 0.2
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - own).max() > 0.01
    lattice.data.points[37].co_deform.x -= 0.2
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - own).max() < 1e-6


def test_vertices_are_embedded_where_the_shape_holds_them():
    """Against numpy: the shaped lattice's own map takes the parameters found to the vertices, and others from there."""
    ball, lattice = bound_ball(Preserve=0.0)
    grid, bound = scenes.part("core.grid"), scenes.part("tool.bound")
    cache = bound.BoundCache()
    cache.look_at(scenes.get_input(ball.modifiers[0], "Viewport Result"))
    embedding = cache.embedding(scenes.part("core.blending").Blending("Bernstein"))
    native = grid.build_lattice(embedding.grid)
    own = scenes.positions(ball.data)
    parameters, inside = native.invert(own, embedding.control)
    assert inside.all()
    for point in lattice.data.points:
        point.co_deform.y *= 1.4
        point.co_deform.z += 0.2 * point.co_deform.x
    bpy.context.view_layer.update()
    control = scenes.report(ball, ball.modifiers[0]).asked
    wanted = native.evaluate(parameters, control)
    assert np.abs(wanted - own).max() > 0.1
    assert np.abs(scenes.evaluated_positions(ball) - wanted).max() < 5e-6


@pytest.mark.parametrize("in_render", [False, True], ids=["viewport", "render"])
@pytest.mark.parametrize("bend", [False, True], ids=["box", "bent"])
def test_keys_on_the_lattice_s_transform_move_the_mesh_rigidly(bend, in_render):
    ball, lattice = bound_ball(bend)
    own = scenes.positions(ball.data)
    for frame, motion in key_motion(lattice).items():
        found = seen(frame, in_render)
        assert np.abs(found - moved(own, motion)).max() < 2e-5
        if in_render:
            assert abs(rendered(frame)[0] / scenes.volume(ball.data) - 1) <= 1e-6
        else:
            assert whole_volume_kept(ball)


def test_without_a_rest_the_same_keys_deform_nothing():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=9.0)
    scenes.volume_lattice(ball, lattice)
    key_motion(lattice)
    bpy.context.scene.frame_set(5)
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 1e-5


def test_motion_is_seen_from_the_object():
    """Object and lattice that move together: nothing moves in the object's space."""
    ball, lattice = bound_ball(Preserve=0.0)
    own = scenes.positions(ball.data)
    lattice.parent = ball
    for place, turn in (((3.0, 1.0, -7.0), (0.3, 0.2, 0.1)), ((113.0, 17.0, 5.0), (1.3, -0.2, 2.1))):
        ball.matrix_world = Matrix.LocRotScale(place, Euler(turn), (1.0, 1.0, 1.0))
        bpy.context.view_layer.update()
        assert np.array_equal(scenes.evaluated_positions(ball), own)


@pytest.mark.parametrize("in_render", [False, True], ids=["viewport", "render"])
def test_the_volume_is_kept_when_a_bound_shape_is_squashed(in_render):
    ball, lattice = bound_ball()
    for factor in (0.7, 0.5):
        for point in lattice.data.points:
            point.co_deform.z *= factor
        bpy.context.view_layer.update()
        if in_render:
            assert abs(rendered(1)[0] / scenes.volume(ball.data) - 1) <= 1e-6
        assert whole_volume_kept(ball)
        assert np.ptp(scenes.evaluated_positions(ball)[:, 2]) < 1.9
    assert problems(ball) == ()


def test_behind_a_deforming_modifier_what_enters_now_is_embedded():
    """A mesh that the stack moves inside the bound lattice still follows the lattice's motion exactly."""
    ball, lattice = bound_ball(Preserve=0.0)
    own = scenes.positions(ball.data)
    hook_target = scenes.linked(bpy.data.objects.new("Handle", None))
    hook = ball.modifiers.new("Hook", "HOOK")
    hook.object = hook_target
    hook.vertex_indices_set(range(len(own)))
    scenes.choose(ball)
    bpy.ops.object.modifier_move_to_index(modifier="Hook", index=0)
    for frame, shift in ((1, 0.0), (9, 0.25)):
        hook_target.location.y = shift
        hook_target.keyframe_insert("location", frame=frame)
    motions = key_motion(lattice)
    for frame in (9, 5, 1):
        bpy.context.scene.frame_set(frame)
        entered = own + (0.0, hook_target.evaluated_get(bpy.context.evaluated_depsgraph_get()).location.y, 0.0)
        found = scenes.evaluated_positions(ball)
        assert np.abs(found - moved(entered, motions[frame])).max() < 2e-5
    assert scenes.report(ball, ball.modifiers[-1]).vertices_outside == 0


def test_outside_says_what_becomes_of_vertices_beyond_the_shape(capfd):
    ball, lattice = bound_ball(bend=False, size=1.9, Preserve=0.0)
    said = capfd.readouterr()
    outside = scenes.report(ball, ball.modifiers[0]).vertices_outside
    assert 0 < outside < len(ball.data.vertices)
    assert f"{outside} of {len(ball.data.vertices)} vertices are not inside the lattice" in said.out + said.err
    lattice.location.x += 1.0
    bpy.context.view_layer.update()
    own = scenes.positions(ball.data)
    shift = scenes.evaluated_positions(ball) - own
    stay = np.abs(shift).max(axis=1) == 0.0
    assert stay.sum() == outside
    assert np.allclose(shift[~stay], (1.0, 0.0, 0.0), atol=1e-5)
    scenes.set_input(ball.modifiers[0], "Outside", "Extend")
    bpy.context.view_layer.update()
    assert np.allclose(scenes.evaluated_positions(ball) - own, (1.0, 0.0, 0.0), atol=1e-5)


def test_clearing_the_rest_embeds_by_the_present_place_again():
    ball, lattice = bound_ball()
    lattice.location.x += 1.0
    bpy.context.view_layer.update()
    assert scenes.evaluated_positions(ball)[:, 0].mean() > 0.9
    bpy.ops.isochor.clear_rest()
    for point in lattice.data.points:
        point.co_deform = point.co
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - scenes.positions(ball.data)).max() < 1e-5
    assert not bpy.ops.isochor.clear_rest.poll()
    with pytest.raises(RuntimeError, match="rest set"):
        bpy.ops.isochor.clear_rest()


def test_binding_measures_the_rest_volume_anew_and_clears_the_word_on_edits():
    ball, lattice = bound_ball()
    before = scenes.volume(ball.data)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(1.2, 1.0, 0.9))
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert any("edited" in text and "Set Rest" in text for text in problems(ball))
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert problems(ball) == ()
    now = scenes.volume(ball.data)
    assert abs(now / before - 1) > 0.05
    for mode in ("Viewport", "Render"):
        kept = scenes.get_input(ball.modifiers[0], f"{mode} Result")["isochor_rest_volume"]
        assert kept == pytest.approx(now, rel=1e-6)
    for point in lattice.data.points:
        point.co_deform.z *= 0.6
    bpy.context.view_layer.update()
    assert whole_volume_kept(ball)


def test_where_renders_see_another_mesh_its_volume_is_measured_on_binding():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.name = "Ball"
    subdivision = cube.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 3
    cube.modifiers.new("Triangulate", "TRIANGULATE")
    bpy.ops.isochor.add(margin=0.5)
    modifier = cube.modifiers.active
    lattice = scenes.get_input(modifier, "Lattice")
    cube.data.attributes["position"].data[0].vector.x *= 1.5
    cube.data.update()
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    kept = scenes.get_input(modifier, "Render Result")["isochor_rest_volume"]
    assert kept == pytest.approx(rendered(1)[0], rel=1e-6)
    assert abs(kept / scenes.evaluated_volume(cube) - 1) > 1e-3
    lattice.scale.z *= 0.5
    bpy.context.view_layer.update()
    assert rendered(1)[0] == pytest.approx(kept, rel=1e-6)
    assert (subdivision.levels, subdivision.render_levels) == (1, 3)


def test_another_resolution_is_told_and_the_frame_undeformed():
    ball, lattice = bound_ball(bend=False)
    lattice.location.z = 1.0
    lattice.data.points_u = 5
    bpy.context.view_layer.update()
    assert any("4×4×4" in text and "5×4×4" in text and "Set Rest" in text for text in problems(ball))
    assert np.array_equal(scenes.evaluated_positions(ball), scenes.positions(ball.data))
    bpy.context.scene.frame_set(3)
    assert np.array_equal(rendered(3)[1], scenes.positions(ball.data))
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert problems(ball) == ()
    lattice.location.z += 0.5
    bpy.context.view_layer.update()
    assert np.allclose(scenes.evaluated_positions(ball) - scenes.positions(ball.data), (0, 0, 0.5), atol=1e-5)


def test_several_objects_of_one_lattice_are_bound_together():
    left, right = scenes.sphere(name="Left"), scenes.sphere(name="Right")
    right.location = (2.0, 0.3, 0.0)
    right.rotation_euler = (0.2, 0.4, 0.0)
    left.select_set(True)
    bpy.context.view_layer.update()
    bpy.ops.isochor.add(margin=0.2)
    lattice = scenes.get_input(left.modifiers[0], "Lattice")
    scenes.choose(lattice)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    motion = Matrix.LocRotScale((1.0, 2.0, 3.0), Euler((0.5, 0.1, 0.9)), None)
    lattice.matrix_world = motion @ lattice.matrix_world
    bpy.context.view_layer.update()
    for ball in (left, right):
        to_world = ball.matrix_world
        found = moved(scenes.evaluated_positions(ball), to_world)
        assert np.abs(found - moved(scenes.positions(ball.data), motion @ to_world)).max() < 2e-5
        assert whole_volume_kept(ball)


def test_copy_of_object_and_of_modifier_stay_bound_and_another_mesh_is_not():
    ball, lattice = bound_ball(bend=False)
    twin = ball.copy()
    twin.data = ball.data.copy()
    bpy.context.scene.collection.objects.link(twin)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.7)
    other = bpy.context.object
    new = other.modifiers.new("Volume Lattice", "NODES")
    new.node_group = ball.modifiers[0].node_group
    for name in ("Lattice", "Viewport Result", "Render Result", "Slot"):
        scenes.set_input(new, name, scenes.get_input(ball.modifiers[0], name))
    bpy.context.view_layer.update()
    lattice.location.x += 1.0
    bpy.context.view_layer.update()
    for obj, shift in ((ball, 1.0), (twin, 1.0), (other, 0.0)):
        found = scenes.evaluated_positions(obj) - scenes.positions(obj.data)
        assert np.allclose(found, (shift, 0.0, 0.0), atol=1e-5), obj.name
    scenes.choose(twin)
    bpy.ops.isochor.clear_rest()
    assert np.allclose(scenes.evaluated_positions(ball) - scenes.positions(ball.data), (1.0, 0.0, 0.0), atol=1e-5)


def test_an_open_mesh_is_bound_and_its_copy_too():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6)
    sheet = bpy.context.object
    bpy.ops.isochor.add(margin=0.2)
    lattice = scenes.get_input(sheet.modifiers[0], "Lattice")
    scenes.set_input(sheet.modifiers[0], "Preserve", 0.0)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    twin = sheet.copy()
    bpy.context.scene.collection.objects.link(twin)
    lattice.location.x += 1.0
    bpy.context.view_layer.update()
    for obj in (sheet, twin):
        assert np.allclose(scenes.evaluated_positions(obj) - scenes.positions(obj.data), (1.0, 0, 0), atol=1e-5)


def test_saved_and_loaded_and_appended(tmp_path):
    ball, lattice = bound_ball()
    key_motion(lattice)
    bpy.context.scene.frame_set(5)
    shape, in_render = scenes.evaluated_positions(ball), rendered(5)[1]
    place = str(tmp_path / "bound.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    bpy.ops.wm.open_mainfile(filepath=place)
    for frame in (9, 5):
        bpy.context.scene.frame_set(frame)
    ball = bpy.data.objects["Ball"]
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() < 1e-6
    assert np.abs(rendered(5)[1] - in_render).max() < 1e-6
    scenes.empty_file()
    with bpy.data.libraries.load(place) as (_there, here):
        here.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    bpy.context.scene.frame_set(5)
    assert np.abs(scenes.evaluated_positions(bpy.data.objects["Ball"]) - shape).max() < 1e-6


def test_setting_and_clearing_are_one_undo_step_each():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=4.5)
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    bent_lattice(lattice)
    deformed = scenes.evaluated_positions(ball)
    own = scenes.positions(ball.data)
    assert np.abs(deformed - own).max() > 0.1
    scenes.choose(ball)
    bpy.ops.ed.undo_push(message="shaped")
    bpy.ops.isochor.set_rest("EXEC_DEFAULT", True)

    def shown() -> Array:
        bpy.context.view_layer.update()
        return scenes.evaluated_positions(bpy.data.objects["Ball"])

    assert np.array_equal(shown(), own)
    bpy.ops.ed.undo()
    assert np.abs(shown() - deformed).max() < 1e-6
    bpy.ops.ed.redo()
    assert np.abs(shown() - own).max() < 1e-6
    bpy.ops.isochor.clear_rest("EXEC_DEFAULT", True)
    assert np.abs(shown() - deformed).max() < 1e-6
    bpy.ops.ed.undo()
    assert np.abs(shown() - own).max() < 1e-6


def test_the_way_back_is_sought_only_when_something_changed(monkeypatch):
    """Frames of a moving lattice cost no new embedding; a mesh edit does."""
    ball, lattice = bound_ball()
    key_motion(lattice)
    bpy.context.scene.frame_set(1)
    solver = scenes.part("core.solver")
    built: list[int] = []
    real: Callable = solver.build_lattice
    monkeypatch.setattr(solver, "build_lattice", lambda grid: built.append(1) or real(grid))
    binding = scenes.report(ball, ball.modifiers[0]).binding
    for frame in range(2, 9):
        bpy.context.scene.frame_set(frame)
        assert scenes.report(ball, ball.modifiers[0]).binding is binding
    assert built == []


def test_refusals_change_nothing():
    with pytest.raises(RuntimeError, match="Select a mesh with a Volume Lattice"):
        bpy.ops.isochor.set_rest()
    ball = scenes.sphere()
    with pytest.raises(RuntimeError, match="Select a mesh with a Volume Lattice"):
        bpy.ops.isochor.set_rest()
    lattice = scenes.lattice_object(4, size=4.5)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0)
    scenes.choose(ball)

    def refused(words: str) -> None:
        with pytest.raises(RuntimeError, match=words):
            bpy.ops.isochor.set_rest()
        for mode in ("Viewport", "Render"):
            assert "isochor_bound" not in scenes.get_input(modifier, f"{mode} Result")

    lattice.scale.z = 0.0
    bpy.context.view_layer.update()
    refused("scale of zero")
    lattice.scale.z = 4.5
    for point in lattice.data.points:
        point.co_deform.z = 0.1
    bpy.context.view_layer.update()
    refused("pressed flat")
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    refused("No lattice")
    scenes.set_input(modifier, "Lattice", scenes.linked(bpy.data.objects.new("Empty", None)))
    scenes.choose(ball)
    bpy.context.view_layer.update()
    refused("not a lattice")


def test_hidden_and_linked_objects_are_refused_in_plain_words(tmp_path):
    ball, _lattice = bound_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    ball.hide_viewport = True
    bpy.context.view_layer.update()
    scenes.choose(bpy.data.objects["Lattice"])
    with pytest.raises(RuntimeError, match="hidden"):
        bpy.ops.isochor.set_rest()
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    bpy.context.view_layer.objects.active = here.objects[0]
    bpy.context.view_layer.update()
    for operator in (bpy.ops.isochor.set_rest, bpy.ops.isochor.clear_rest):
        with pytest.raises(RuntimeError, match="another file"):
            operator()


def test_a_lattice_is_bound_in_its_edit_mode_as_it_looks_there():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=4.5)
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(1.2, 0.8, 0.6))
    bpy.context.view_layer.update()
    own = scenes.positions(ball.data)
    assert np.abs(scenes.evaluated_positions(ball) - own).max() > 0.1
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert np.abs(scenes.evaluated_positions(ball) - own).max() < 1e-5
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - own).max() < 1e-5
    lattice.location.z += 1.0
    bpy.context.view_layer.update()
    assert np.allclose(scenes.evaluated_positions(ball) - own, (0.0, 0.0, 1.0), atol=1e-5)


def test_a_hidden_lattice_is_bound_all_the_same():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4, size=4.5)
    scenes.volume_lattice(ball, lattice, Preserve=0.0)
    lattice.hide_viewport = True
    lattice.hide_set(True)
    bpy.context.view_layer.update()
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    lattice.location.z += 1.0
    bpy.context.view_layer.update()
    moved_by = scenes.evaluated_positions(ball) - scenes.positions(ball.data)
    assert np.allclose(moved_by, (0.0, 0.0, 1.0), atol=1e-5)


def test_a_library_override_is_bound_as_the_library_has_it_and_anew(tmp_path):
    bound_ball(Preserve=0.0)
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball", "Lattice"]
    for linked in here.objects:
        bpy.context.scene.collection.objects.link(linked.override_create(remap_local_usages=True))
    ball, lattice = (next(obj for obj in bpy.context.scene.objects if obj.type == kind) for kind in ("MESH", "LATTICE"))
    scenes.set_input(ball.modifiers[0], "Lattice", lattice)
    bpy.context.view_layer.update()
    own = scenes.positions(ball.data)
    for _ in range(2):
        lattice.location.x += 0.1
        bpy.context.view_layer.update()
        assert np.allclose(scenes.evaluated_positions(ball) - own, (0.1, 0.0, 0.0), atol=1e-5)
        scenes.choose(ball)
        assert bpy.ops.isochor.set_rest() == {"FINISHED"}
        assert np.abs(scenes.evaluated_positions(ball) - own).max() < 1e-5


def test_the_panel_says_what_is_bound():
    ball, _lattice = bound_ball()
    panel = scenes.part("ui.binding_panel")
    assert panel.state_of(ball.modifiers[0]) == "bound with “Lattice”, 4×4×4 points"
    bpy.ops.isochor.clear_rest()
    assert panel.state_of(ball.modifiers[0]).startswith("not bound")
    assert bpy.types.VIEW3D_PT_isochor_bind.bl_parent_id == "VIEW3D_PT_isochor"
