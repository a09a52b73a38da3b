# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins: where an empty goes, its point of the surface goes too, exactly, and the volume stays."""

import bpy
import drawn
import numpy as np
import pin_scenes
import pytest
import scenes
from pin_scenes import EXACT, FAR, NEAR, holds, keeps_volume, move, pin, squashed_ball


def test_adding_puts_an_empty_on_the_vertex_and_moves_nothing():
    ball, modifier = squashed_ball()
    before = scenes.evaluated_positions(ball)
    (empty,) = pin(ball, NEAR)
    held = scenes.get_input(modifier, "Pins")
    assert held.name == "Ball Pins"
    assert list(held.all_objects) == [empty]
    assert empty.type == "EMPTY"
    assert held.name in bpy.context.scene.collection.children
    assert np.abs(scenes.evaluated_positions(ball) - before).max() <= EXACT
    assert holds(ball, empty, NEAR)
    assert scenes.report(ball, modifier).problems == ()


@pytest.mark.parametrize("method", ["Balanced", "Sweep", "Gradient", "Nearest"])
def test_moving_the_empty_moves_the_vertex_exactly_and_keeps_the_volume(method):
    ball, _ = squashed_ball(Method=method)
    (empty,) = pin(ball, NEAR)
    for way in ((0.3, -0.2, 0.25), (-0.5, 0.4, 0.1), (0.0, 0.0, -0.6)):
        move(empty, *way)
        assert holds(ball, empty, NEAR)
        assert keeps_volume(ball)


def test_several_pins_hold_at_once_and_a_later_one_can_be_added():
    ball, modifier = squashed_ball()
    empties = pin(ball, NEAR, FAR, 300)
    move(empties[0], 0.2, 0.1, 0.3)
    move(empties[2], -0.1, 0.2, 0.0)
    (later,) = pin(ball, 120)
    move(later, 0.0, -0.15, 0.0)
    for empty, vertex in zip([*empties, later], (NEAR, FAR, 300, 120), strict=True):
        assert holds(ball, empty, vertex)
    assert keeps_volume(ball)
    assert len(scenes.report(ball, modifier).pins) == 4
    assert scenes.report(ball, modifier).largest_miss <= EXACT


def test_shaping_comes_first_and_the_pin_has_the_last_word():
    ball, modifier = squashed_ball()
    empties = pin(ball, NEAR, FAR)
    for name, value in (("Twist", 0.8), ("Squash", 0.8), ("Bend", 0.3)):
        scenes.set_input(modifier, name, value)
        bpy.context.view_layer.update()
        assert all(holds(ball, empty, vertex) for empty, vertex in zip(empties, (NEAR, FAR), strict=True))
        assert keeps_volume(ball)


def test_object_with_a_transform_of_its_own():
    ball, _ = squashed_ball()
    cage = bpy.data.objects["Ball Cage"]
    cage.parent = ball
    ball.location, ball.rotation_euler, ball.scale = (3.0, -2.0, 1.0), (0.3, 0.8, -0.4), (1.0, 1.6, 0.7)
    bpy.context.view_layer.update()
    (empty,) = pin(ball, NEAR)
    move(empty, 0.2, 0.3, -0.1)
    assert holds(ball, empty, NEAR)
    ball.location.x += 0.4
    bpy.context.view_layer.update()
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)


def test_pin_that_follows_the_object():
    ball, _ = squashed_ball()
    scenes.choose(ball)
    ball.data.vertices.foreach_set("select", np.arange(len(ball.data.vertices)) == NEAR)
    ball.location = (1.0, 0.0, 0.0)
    bpy.data.objects["Ball Cage"].parent = ball
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.add_pin(follow=True) == {"FINISHED"}
    empty = bpy.context.view_layer.objects.active
    move(empty, 0.0, 0.0, 0.2)
    shape = scenes.evaluated_positions(ball)
    assert holds(ball, empty, NEAR)
    ball.location = (4.0, 2.0, -1.0)
    bpy.context.view_layer.update()
    assert holds(ball, empty, NEAR)
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() <= 1e-5


def test_parented_constrained_driven_and_hidden_empties():
    ball, _ = squashed_ball()
    empties = pin(ball, NEAR, FAR, 300)
    parent = scenes.linked(bpy.data.objects.new("Parent", None))
    empties[0].parent = parent
    constraint = empties[1].constraints.new("COPY_LOCATION")
    constraint.target, constraint.use_offset = parent, True
    curve = empties[2].driver_add("location", 2)
    variable = curve.driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = parent, "location.z"
    curve.driver.expression = f"{empties[2].location.z} + {variable.name}"
    empties[0].hide_set(True)
    empties[1].hide_viewport = empties[1].hide_render = True
    for height in (0.1, 0.3, -0.2):
        parent.location = (0.05, 0.1, height)
        bpy.context.view_layer.update()
        assert all(holds(ball, empty, vertex) for empty, vertex in zip(empties, (NEAR, FAR, 300), strict=True))
        assert keeps_volume(ball)


def test_pins_of_an_excluded_collection_and_of_one_below_hold():
    ball, modifier = squashed_ball()
    first, second = pin(ball, NEAR, FAR)
    held, below = scenes.get_input(modifier, "Pins"), bpy.data.collections.new("Below")
    held.objects.unlink(second)
    below.objects.link(second)
    held.children.link(below)
    bpy.context.view_layer.layer_collection.children[held.name].exclude = True
    for empty, vertex in ((first, NEAR), (second, FAR)):
        move(empty, 0.1, 0.0, 0.2)
        assert holds(ball, empty, vertex)


def test_animated_empty_in_playback():
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    for frame, height in ((1, 0.0), (5, 0.5), (9, -0.2)):
        empty.location.z = 0.5 + height
        empty.keyframe_insert("location", frame=frame)
    heights = set()
    for frame, subframe in ((1, 0.0), (3, 0.5), (5, 0.0), (9, 0.0)):
        bpy.context.scene.frame_set(frame, subframe=subframe)
        assert holds(ball, empty, NEAR)
        assert keeps_volume(ball)
        heights.add(round(float(pin_scenes.place(empty)[2]), 3))
    assert len(heights) == 4


class PinEngine(bpy.types.RenderEngine):
    """Instead of a picture it notes how far the pinned vertex is from its empty, and the volume."""

    bl_idname = "ISOCHOR_PINS"
    bl_label = "Pins"
    noted: list[tuple[int, int, np.ndarray, np.ndarray, float]] = []

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        ball, empty = bpy.data.objects["Ball"], bpy.data.objects["Ball Pin"]
        shape = pin_scenes.in_world(ball, depsgraph)
        volume = scenes.volume(scenes.evaluated_mesh(ball, depsgraph))
        frame = depsgraph.scene.frame_current
        self.noted.append((frame, len(shape), shape[NEAR], pin_scenes.place(empty, depsgraph), volume))


@pytest.fixture
def noted():
    """What the engine saw."""
    bpy.utils.register_class(PinEngine)
    PinEngine.noted.clear()
    yield PinEngine.noted
    bpy.utils.unregister_class(PinEngine)


def test_animated_empty_in_a_render_with_another_subdivision(noted, tmp_path):
    ball, _ = squashed_ball()
    finer = ball.modifiers.new("Finer", "SUBSURF")
    finer.levels, finer.render_levels = 0, 1
    ball.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    (empty,) = pin(ball, NEAR)
    for frame, height in ((1, 0.0), (5, 0.5)):
        empty.location.z = 0.5 + height
        empty.keyframe_insert("location", frame=frame)
    empty.hide_render = True
    scene = bpy.context.scene
    scene.camera = scenes.linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    scene.render.engine, scene.render.filepath = PinEngine.bl_idname, str(tmp_path / "frame_")
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 5, 2
    bpy.ops.render.render(animation=True)
    assert [frame for frame, *_ in noted] == [1, 3, 5]
    assert all(count > len(ball.data.vertices) for _frame, count, *_ in noted)
    assert all(np.linalg.norm(vertex - target) <= EXACT for _frame, _count, vertex, target, _volume in noted)
    volumes = [volume for *_, volume in noted]
    assert np.ptp(volumes) <= 2e-6 * volumes[0]
    assert len({round(float(target[2]), 3) for *_, target, _volume in noted}) == 3


def test_mesh_that_an_earlier_modifier_moves_is_held_in_every_frame():
    ball, _ = squashed_ball()
    wave = ball.modifiers.new("Wave", "WAVE")
    wave.height = 0.2
    ball.modifiers.move(1, 0)
    bpy.context.scene.frame_set(10)
    (empty,) = pin(ball, NEAR)
    own = []
    for frame in (10, 14, 20):
        bpy.context.scene.frame_set(frame)
        assert holds(ball, empty, NEAR)
        own.append(scenes.evaluated_positions(ball)[FAR])
    assert not np.allclose(own[0], own[1], atol=1e-4)


def test_falloff_keeps_the_rest_still():
    moved = {}
    for falloff in (0.0, 0.5, 0.25, 0.1):
        scenes.empty_file()
        ball, modifier = squashed_ball(squash=1.0, side=9, size=3.5, Basis="B-Spline")
        (empty,) = pin(ball, NEAR)
        scenes.set_input(modifier, "Falloff", falloff)
        bpy.context.view_layer.update()
        before = scenes.evaluated_positions(ball)
        away = np.linalg.norm(before - before[NEAR], axis=1) > 1.2
        move(empty, *(0.3 * before[NEAR] / np.linalg.norm(before[NEAR])))
        assert holds(ball, empty, NEAR)
        assert keeps_volume(ball)
        moved[falloff] = np.linalg.norm(scenes.evaluated_positions(ball) - before, axis=1)[away].max()
    assert moved[0.0] > moved[0.5] > moved[0.25] > moved[0.1]
    assert moved[0.1] < 0.01 * 0.3


def test_falloff_is_a_length_in_the_world():
    shapes = []
    for scale in (1.0, 0.01):
        scenes.empty_file()
        ball, modifier = squashed_ball()
        bpy.data.objects["Ball Cage"].parent = ball
        ball.scale = (scale, scale, scale)
        bpy.context.view_layer.update()
        (empty,) = pin(ball, NEAR)
        scenes.set_input(modifier, "Falloff", 0.3 * scale)
        move(empty, 0.2 * scale, 0.0, 0.1 * scale)
        shapes.append(scenes.evaluated_positions(ball))
    assert np.abs(shapes[0] - shapes[1]).max() <= 1e-4


@pytest.mark.parametrize("method", ["Balanced", "Gradient", "Nearest"])
def test_preserve_0_still_holds_and_leaves_the_volume(method):
    ball, modifier = squashed_ball(Preserve=0.0, Method=method, Unfolded=True)
    (empty,) = pin(ball, NEAR)
    move(empty, 0.4, 0.0, 0.4)
    assert holds(ball, empty, NEAR)
    assert not keeps_volume(ball)
    assert scenes.report(ball, modifier).problems == ()
    assert scenes.report(ball, modifier).notes == []
    assert scenes.report(ball, modifier).volumes is None
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)


def flat_sheet(side: int, preserve: float) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A square of 8 by 8 faces in a lattice."""
    points = [(x, y, 0.0) for y in np.linspace(-1, 1, 9) for x in np.linspace(-1, 1, 9)]
    faces = [(i + j, i + j + 1, i + j + 10, i + j + 9) for j in range(0, 72, 9) for i in range(8)]
    sheet = scenes.mesh_object("Sheet", points, faces)
    return sheet, scenes.volume_lattice(sheet, scenes.lattice_object(side), Preserve=preserve)


@pytest.mark.parametrize("preserve", [0.0, 1.0])
def test_open_mesh_is_held_all_the_same(preserve):
    sheet, modifier = flat_sheet(4, preserve)
    (empty,) = pin(sheet, 40)
    move(empty, 0.1, 0.2, 0.5)
    assert holds(sheet, empty, 40)
    assert bool(scenes.report(sheet, modifier).problems) == (preserve > 0.0)


def test_vertices_without_faces_are_held():
    cloud = scenes.mesh_object("Cloud", scenes.sphere_arrays(8, 6)[0], [])
    scenes.volume_lattice(cloud, scenes.lattice_object(4), Preserve=0.0)
    (empty,) = pin(cloud, 7)
    move(empty, 0.1, 0.2, 0.5)
    assert holds(cloud, empty, 7)


def test_empty_collection_is_no_pins():
    ball, modifier = squashed_ball()
    before = scenes.evaluated_positions(ball)
    scenes.set_input(modifier, "Pins", bpy.data.collections.new("Nothing"))
    scenes.set_input(modifier, "Falloff", 0.2)
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.evaluated_positions(ball), before)
    assert scenes.report(ball, modifier).pins is None
    assert scenes.report(ball, modifier).problems == ()


def test_two_modifiers_of_two_objects_share_an_empty_and_meet_there():
    ball, _ = squashed_ball("Ball")
    other, modifier = squashed_ball("Other")
    other.location.x = 2.5
    bpy.data.objects["Other Cage"].location.x = 2.5
    bpy.context.view_layer.update()
    (empty,) = pin(ball, NEAR)
    scenes.choose(other)
    empty.select_set(True)
    assert bpy.ops.isochor.bind_pins() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert empty in list(scenes.get_input(modifier, "Pins").all_objects)
    at_first = scenes.evaluated_positions(other)
    move(empty, 0.2, 0.0, 0.1)
    assert holds(ball, empty, NEAR)
    assert keeps_volume(ball)
    assert keeps_volume(other)
    moved = scenes.evaluated_positions(other) - at_first
    largest = moved[np.argmax(np.linalg.norm(moved, axis=1))]
    assert np.linalg.norm(largest) > 0.1
    assert scenes.report(other, modifier).largest_miss <= EXACT


def test_contradicting_pins_are_named_and_the_frame_is_uncorrected():
    ball, modifier = squashed_ball()
    (empty,) = pin(ball, NEAR)
    empty.name = "Nose"
    twin = empty.copy()
    twin.name = "Nase"
    scenes.get_input(modifier, "Pins").objects.link(twin)
    move(twin, 0.3, 0.0, 0.0)
    said = pin_scenes.problems(ball, modifier)
    assert "“Nose”" in said
    assert "“Nase”" in said
    assert "different places" in said
    found = scenes.evaluated_positions(ball)
    scenes.set_input(modifier, "Preserve", 0.0)
    scenes.set_input(modifier, "Pins", None)
    bpy.context.view_layer.update()
    assert np.array_equal(found, scenes.evaluated_positions(ball))


def test_pin_that_the_lattice_cannot_move_is_named():
    ball, modifier = squashed_ball()
    ball.vertex_groups.new(name="Half").add([vertex for vertex in range(386) if vertex != NEAR], 1.0, "REPLACE")
    scenes.set_input(modifier, "Vertex Group", "Half")
    bpy.context.view_layer.update()
    (empty,) = pin(ball, NEAR)
    assert f"“{empty.name}” holds a point that the lattice cannot move" in pin_scenes.problems(ball, modifier)


def test_more_pins_than_the_lattice_can_tell_apart_are_named():
    sheet, modifier = flat_sheet(2, 0.0)
    pin(sheet, 0, 8, 72, 80)
    assert scenes.report(sheet, modifier).problems == ()
    pin(sheet, 40)
    assert "cannot move apart from each other" in pin_scenes.problems(sheet, modifier)
    assert "“Sheet Pin.004”" in pin_scenes.problems(sheet, modifier)


def test_pins_close_by_that_pull_apart_are_named():
    ball, modifier = squashed_ball()
    point = pin_scenes.in_world(ball)[NEAR]
    for step in (0.0, 1e-4):
        scenes.choose(ball)
        assert bpy.ops.isochor.add_pin(where="POINT", point=point + (step, 0.0, 0.0)) == {"FINISHED"}
    empty = bpy.context.view_layer.objects.active
    assert scenes.report(ball, modifier).problems == ()
    move(empty, 0.0, 0.0, 1.0)
    assert "too near each other" in pin_scenes.problems(ball, modifier)


def test_the_panel_says_how_many_hold_and_how_exactly():
    ball, modifier = squashed_ball()
    panel, shown = scenes.part("ui.pin_panel").VIEW3D_PT_isochor_pins, {"object": ball}
    assert "no pins" in " ".join(drawn.drawn(panel, **shown))
    empties = pin(ball, NEAR, FAR)
    scenes.choose(ball)
    assert "2 pins, largest miss" in " ".join(drawn.drawn(panel, **shown))
    sidebar = scenes.part("ui.sidebar").VIEW3D_PT_isochor
    assert "Target volume" in drawn.drawn(sidebar, object=empties[0])
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    lines = drawn.drawn(sidebar, object=empties[0])
    assert "Target volume" not in lines
    assert "Points moved up to" in lines


@pytest.mark.parametrize("kind", ["PC2", "SHAPE_KEYS", "LATTICE"])
def test_a_bake_holds_without_the_add_on(kind, tmp_path):
    ball, _ = squashed_ball(side=4)
    (empty,) = pin(ball, NEAR)
    for frame, height in ((1, 0.3), (5, 0.8)):
        empty.location.z = height
        empty.keyframe_insert("location", frame=frame)
    scenes.choose(ball)
    done = bpy.ops.isochor.bake(format=kind, frame_start=1, frame_end=5, directory=str(tmp_path))
    assert done == {"FINISHED"}
    for frame in (1, 3, 5):
        bpy.context.scene.frame_set(frame)
        assert np.linalg.norm(pin_scenes.in_world(ball)[NEAR] - pin_scenes.place(empty)) <= 5 * EXACT


def test_applying_keeps_the_shape_and_takes_the_pins_away():
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    move(empty, 0.2, 0.0, 0.3)
    shape, target = scenes.evaluated_positions(ball), pin_scenes.place(empty)
    scenes.choose(ball)
    assert bpy.ops.isochor.apply() == {"FINISHED"}
    assert np.array_equal(scenes.positions(ball.data), shape)
    assert np.linalg.norm(shape[NEAR] - target) <= EXACT
    assert "Ball Pins" not in bpy.data.collections


def test_frame_memory_tells_frames_apart_by_the_pins_alone():
    ball, _ = squashed_ball()
    (empty,) = pin(ball, NEAR)
    scenes.part("tool.frame_memory")._frames.resize(64 * 2**20)
    for frame, height in ((1, 0.3), (5, 0.8)):
        empty.location.z = height
        empty.keyframe_insert("location", frame=frame)
    for frame in (1, 3, 5, 1, 3, 5, 1, 3, 5):
        bpy.context.scene.frame_set(frame)
        assert holds(ball, empty, NEAR)
