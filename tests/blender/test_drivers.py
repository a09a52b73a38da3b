# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators that put ready drivers: from a ground, a bone and an empty; simple expressions all of them."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix, Vector


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(obj)
    return obj


def empty_object(name: str, place=(0.0, 0.0, 0.0)) -> bpy.types.Object:
    obj = linked(bpy.data.objects.new(name, None))
    obj.location = place
    return obj


def ground_object(height: float = 0.0) -> bpy.types.Object:
    mesh = bpy.data.meshes.new("Ground")
    mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    ground = linked(bpy.data.objects.new("Ground", mesh))
    ground.location.z = height
    return ground


def ball_that_carries_its_lattice(**options) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    ball = scenes.sphere()
    bpy.ops.isochor.add(**options)
    modifier = ball.modifiers.active
    lattice = scenes.get_input(modifier, "Lattice")
    lattice.parent = ball
    return ball, modifier


def select(*objects: bpy.types.Object) -> None:
    """Selects these, the first one active."""
    scenes.choose(objects[0])
    for obj in objects[1:]:
        obj.select_set(True)
    bpy.context.view_layer.update()


def evaluated_input(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str) -> float:
    held = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return scenes.get_input(held.modifiers[modifier.name], name)


def all_drivers() -> list[bpy.types.FCurve]:
    return [curve for obj in bpy.data.objects if obj.animation_data for curve in obj.animation_data.drivers]


def all_are_simple() -> bool:
    found = all_drivers()
    return bool(found) and all(c.driver.is_simple_expression and len(c.driver.expression) < 256 for c in found)


def lowest(obj: bpy.types.Object) -> float:
    matrix = np.array(obj.matrix_world, np.float64)
    return float((scenes.evaluated_positions(obj) @ matrix[:3, :3].T + matrix[:3, 3])[:, 2].min())


@pytest.mark.parametrize("pivot", ["CENTRE", "TOP"])
@pytest.mark.parametrize(("basis", "margin", "scale"), [("BERNSTEIN", 0.05, 1.0), ("BSPLINE", 0.3, 1.7)])
def test_a_ball_pressed_against_the_ground_stands_on_it_and_keeps_its_volume(pivot, basis, margin, scale):
    ball, modifier = ball_that_carries_its_lattice(basis=basis, margin=margin)
    ball.scale = (scale, scale, scale)
    ground = ground_object(0.7)
    ball.location.z = 5.0
    select(ball, ground)
    assert bpy.ops.isochor.squash_from_ground(pivot=pivot) == {"FINISHED"}
    assert all_are_simple()
    whole = scenes.volume(ball.data)
    for ground_height, height in ((0.7, 5.0), (0.7, 2.7), (0.7, 1.9), (0.7, 1.4), (1.5, 2.4), (-3.0, 2.4)):
        ground.location.z, ball.location.z = ground_height, height
        bpy.context.view_layer.update()
        untouched = scale * scenes.positions(ball.data)[:, 2].min() + height
        assert lowest(ball) == pytest.approx(max(ground_height, untouched), abs=2e-5)
        assert abs(scenes.evaluated_volume(ball) / whole - 1.0) <= 1e-6
        assert scenes.report(ball, modifier).problems == ()


def test_the_ground_s_own_top_counts_and_the_squash_has_a_limit():
    ball, modifier = ball_that_carries_its_lattice(margin=0.0)
    bpy.ops.mesh.primitive_cube_add(size=2.0, location=(0, 0, 0))
    slab = bpy.context.object
    ball.location.z = 4.0
    select(ball, slab)
    assert bpy.ops.isochor.squash_from_ground(least=0.5) == {"FINISHED"}
    ball.location.z = 1.7
    bpy.context.view_layer.update()
    assert lowest(ball) == pytest.approx(1.0, abs=1e-5)
    ball.location.z = 0.0
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Squash") == pytest.approx(0.5, abs=1e-6)


def test_a_lattice_upside_down_or_on_its_side_is_pressed_along_its_upright_axis():
    for turn, name in (((math.pi, 0, 0), "Z"), ((0, math.pi / 2, 0), "X"), ((math.pi / 2, 0, 0), "Y")):
        scenes.empty_file()
        ball = scenes.sphere()
        lattice = scenes.lattice_object(4)
        lattice.rotation_euler = turn
        modifier = scenes.volume_lattice(ball, lattice)
        lattice.parent = ball
        ground = ground_object(0.0)
        ball.location.z = 4.0
        select(ball, ground)
        assert bpy.ops.isochor.squash_from_ground(pivot="TOP") == {"FINISHED"}
        assert scenes.get_input(modifier, "Axis") == name
        ball.location.z = 0.5
        bpy.context.view_layer.update()
        assert lowest(ball) == pytest.approx(0.0, abs=1e-5)


def test_drivers_work_in_a_reopened_file_with_auto_run_off(tmp_path):
    ball, modifier = ball_that_carries_its_lattice()
    ground = ground_object()
    ball.location.z = 4.0
    select(ball, ground)
    bpy.ops.isochor.squash_from_ground()
    empty = empty_object("Goal", (0.0, 0.0, 6.0))
    select(ball, empty)
    bpy.ops.isochor.bend_from_empty()
    armature = bone_beside(ball)
    select(ball, armature)
    bpy.ops.isochor.twist_from_bone()
    place = str(tmp_path / "driven.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.context.preferences.filepaths.use_scripts_auto_execute = False
    bpy.ops.wm.open_mainfile(filepath=place, use_scripts=False)
    assert not bpy.app.autoexec_fail
    ball = bpy.data.objects["Ball"]
    modifier = ball.modifiers[0]
    ball.location.z = 0.5
    bpy.data.objects["Goal"].location = (2.0, 2.0, 0.5)
    turn_bone(bpy.data.objects["Rig"], 0.7)
    bpy.context.view_layer.update()
    assert len(all_drivers()) == 4
    assert all_are_simple()
    assert all(curve.driver.is_valid for curve in all_drivers())
    assert evaluated_input(ball, modifier, "Squash") < 0.6
    assert evaluated_input(ball, modifier, "Twist") == pytest.approx(0.7, abs=1e-5)
    assert evaluated_input(ball, modifier, "Bend") > 1.0
    assert evaluated_input(ball, modifier, "Bend Direction") == pytest.approx(math.pi / 4, abs=5e-3)
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) <= 1e-6


def bone_beside(ball: bpy.types.Object, direction=(0.0, 0.0, 1.0)) -> bpy.types.Object:
    """An armature with one bone along a direction of the world."""
    rig = linked(bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
    scenes.choose(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("Roll")
    bone.head, bone.tail = (0, 0, 0), direction
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.data.bones.active = rig.data.bones["Roll"]
    scenes.choose(ball)
    return rig


def turn_bone(rig: bpy.types.Object, angle: float, tilt: float = 0.0) -> None:
    bone = rig.pose.bones["Roll"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = (tilt, angle, 0.0)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1)])
def test_the_twist_follows_the_bone_s_roll_in_the_sense_of_the_world(direction):
    ball, modifier = ball_that_carries_its_lattice(margin=0.0)
    rig = bone_beside(ball, direction)
    select(ball, rig)
    assert bpy.ops.isochor.twist_from_bone() == {"FINISHED"}
    assert all_are_simple()
    middle = np.array(scenes.get_input(modifier, "Lattice").matrix_world.translation) * (1.0, 1.0, 0.0)
    before = scenes.report(ball, modifier).asked[:, :, -1] - middle
    for angle in (0.5, -1.2, 2.5):
        turn_bone(rig, angle)
        bpy.context.view_layer.update()
        assert abs(evaluated_input(ball, modifier, "Twist")) == pytest.approx(abs(angle), abs=1e-5)
        bone = np.array(rig.matrix_world @ rig.pose.bones["Roll"].matrix)
        rest = np.array(rig.matrix_world @ rig.data.bones["Roll"].matrix_local)
        turn = bone[:3, :3] @ rest[:3, :3].T
        assert np.abs(scenes.report(ball, modifier).asked[:, :, -1] - middle - before @ turn.T).max() < 1e-5


def test_twist_takes_a_share_of_a_bone_named_and_leaves_its_tilt_aside():
    ball, modifier = ball_that_carries_its_lattice()
    rig = bone_beside(ball)
    assert bpy.ops.isochor.twist_from_bone(armature="Rig", bone="Roll", factor=0.5) == {"FINISHED"}
    turn_bone(rig, 0.0, tilt=0.8)
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Twist") == pytest.approx(0.0, abs=1e-5)
    turn_bone(rig, 0.9)
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Twist") == pytest.approx(0.45, abs=1e-5)


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
@pytest.mark.parametrize("pivot", ["Bottom", "Centre", "Top"])
@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_the_far_end_bends_until_it_lies_on_the_line_to_the_empty(axis, pivot, basis):
    ball = scenes.sphere()
    side = 5
    lattice = scenes.lattice_object(side)
    lattice.matrix_world = Matrix.LocRotScale((1.0, -2.0, 0.5), Euler((0.7, -0.4, 1.3)), (1.3, 2.1, 3.2))
    modifier = scenes.volume_lattice(ball, lattice, Basis=basis, Preserve=0.0, Axis=axis, Pivot=pivot)
    empty = empty_object("Goal", (1, 1, 1))
    select(ball, empty)
    assert bpy.ops.isochor.bend_from_empty() == {"FINISHED"}
    assert all_are_simple()
    number = "XYZ".index(axis)
    inset = 1 if basis == "B-Spline" else 0
    for place in ((3.0, 1.0, 2.0), (-1.0, -4.0, 0.0), (2.0, -2.5, 6.0)):
        empty.location = place
        lattice.rotation_euler.z += 0.3
        bpy.context.view_layer.update()
        line = np.moveaxis(scenes.report(ball, modifier).asked, number, 0)[:, 2, 2]
        fixed = {"Bottom": line[inset], "Centre": line[2], "Top": line[-1 - inset]}[pivot]
        far = line[inset] if pivot == "Top" else line[-1 - inset]
        chord, way = far - fixed, np.array(place) - fixed
        assert np.linalg.norm(np.cross(chord, way)) < 1e-4 * np.linalg.norm(chord) * np.linalg.norm(way)
        assert chord @ way > 0.0


def test_without_an_empty_one_is_made_that_goes_with_the_lattice_and_undone_with_the_drivers():
    ball, modifier = ball_that_carries_its_lattice(margin=0.0)
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.isochor.bend_from_empty("EXEC_DEFAULT", True) == {"FINISHED"}
    empty = bpy.data.objects["Ball Bend"]
    assert empty.parent == scenes.get_input(modifier, "Lattice")
    bpy.context.view_layer.update()
    top = scenes.positions(ball.data)[:, 2].max()
    assert empty.matrix_world.translation.z == pytest.approx(top, rel=1e-3)
    assert evaluated_input(ball, modifier, "Bend") == pytest.approx(0.0, abs=1e-5)
    ball.location, ball.rotation_euler = (3.0, 2.0, 1.0), (0.4, 0.2, 0.9)
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Bend") == pytest.approx(0.0, abs=1e-5)
    empty.location.x += 1.0
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Bend") > 0.5
    bpy.ops.ed.undo()
    assert "Ball Bend" not in bpy.data.objects
    assert all_drivers() == []


@pytest.mark.parametrize("kind", ["ground", "bone"])
def test_drivers_are_one_undo_step(kind):
    ball, modifier = ball_that_carries_its_lattice()
    other = ground_object() if kind == "ground" else bone_beside(ball)
    if kind == "ground":
        ball.location.z = 4.0
    select(ball, other)
    axes = tuple(scenes.get_input(modifier, "Axes"))
    bpy.ops.ed.undo_push(message="before")
    operator = bpy.ops.isochor.squash_from_ground if kind == "ground" else bpy.ops.isochor.twist_from_bone
    assert operator("EXEC_DEFAULT", True) == {"FINISHED"}
    assert len(all_drivers()) == 1
    bpy.ops.ed.undo()
    modifier = bpy.data.objects["Ball"].modifiers[0]
    assert all_drivers() == []
    assert tuple(scenes.get_input(modifier, "Axes")) == axes
    assert scenes.get_input(modifier, "Pivot") == "Bottom"
    bpy.ops.ed.redo()
    assert len(all_drivers()) == 1


def test_several_selected_meshes_and_a_selected_lattice_are_all_driven():
    ground = ground_object()
    balls = []
    for index in range(2):
        ball, modifier = ball_that_carries_its_lattice()
        ball.location = (4.0 * index, 0.0, 4.0)
        balls.append((ball, modifier))
    lattice = scenes.get_input(balls[1][1], "Lattice")
    select(balls[0][0], lattice, ground)
    assert bpy.ops.isochor.squash_from_ground() == {"FINISHED"}
    assert [len(ball.animation_data.drivers) for ball, _ in balls] == [1, 1]


def test_run_again_it_replaces_its_own_driver():
    ball, modifier = ball_that_carries_its_lattice()
    ball.location.z = 4.0
    select(ball, ground_object())
    for least in (0.3, 0.6):
        assert bpy.ops.isochor.squash_from_ground(least=least) == {"FINISHED"}
    (curve,) = all_drivers()
    assert sorted(variable.name for variable in curve.driver.variables) == ["ground", "height"]
    ball.location.z = 0.0
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Squash") == pytest.approx(0.6, abs=1e-6)


def refused(operator, words: str, **options) -> None:
    """Runs the operator, which must refuse in these words and change nothing."""
    drivers = [(curve.data_path, curve.driver.expression) for curve in all_drivers()]
    objects = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match=words):
        operator(**options)
    assert [(curve.data_path, curve.driver.expression) for curve in all_drivers()] == drivers
    assert len(bpy.data.objects) == objects


def test_refusals():
    ball, modifier = ball_that_carries_its_lattice()
    squash, twist, bend = (
        bpy.ops.isochor.squash_from_ground,
        bpy.ops.isochor.twist_from_bone,
        bpy.ops.isochor.bend_from_empty,
    )
    refused(squash, "Ground: select one other object as well, or name it .found none.")
    refused(squash, "Ground: there is no object “Floor”", ground="Floor")
    refused(twist, "Armature: select an object of the kind armature as well")
    one, two = empty_object("One"), empty_object("Two")
    refused(twist, "Armature: “One” is of the kind empty; it must be armature", armature="One")
    select(ball, one, two)
    refused(squash, "found One, Two")
    refused(bend, "Empty: select one other object as well, or name it .found One, Two.")
    refused(bend, "Empty: there is no object “Goal”", empty="Goal")
    rig = linked(bpy.data.objects.new("Bare", bpy.data.armatures.new("Bare")))
    refused(twist, "“Bare” has no active bone", armature="Bare")
    refused(twist, "“Bare” has no bone “Arm”", armature="Bare", bone="Arm")
    assert rig.name == "Bare"
    scenes.get_input(modifier, "Lattice").rotation_euler = (0.7, 0.5, 0.0)
    bpy.context.view_layer.update()
    refused(squash, "No axis of the lattice of “Ball” is upright", ground="One")
    scenes.set_input(modifier, "Lattice", None)
    refused(squash, "The Volume Lattice of “Ball” has no lattice", ground="One")
    refused(bend, "The Volume Lattice of “Ball” has no lattice", empty="One")


def test_nothing_to_press_is_refused():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    lattice.location.z = -10.0
    scenes.volume_lattice(ball, lattice)
    refused(bpy.ops.isochor.squash_from_ground, "“Ball” has nothing below the pivot", ground=empty_object("One").name)


def test_keys_and_drivers_of_the_animator_are_not_thrown_away():
    ball, modifier = ball_that_carries_its_lattice()
    goal = empty_object("Goal", (1.0, 0.0, 3.0))
    path = scenes.part("tool.drivers").data_path(modifier, "Bend")
    curve = ball.driver_add(path)
    curve.driver.expression = "frame * 0.1"
    refused(bpy.ops.isochor.bend_from_empty, "Bend of “Ball” has a driver of yours already", empty="Goal")
    assert bpy.ops.isochor.bend_from_empty(empty="Goal", replace=True) == {"FINISHED"}
    assert all_are_simple()
    ball.keyframe_insert(scenes.part("tool.drivers").data_path(modifier, "Twist"), frame=1)
    bone_beside(ball)
    refused(bpy.ops.isochor.twist_from_bone, "Twist of “Ball” has keys", armature="Rig", replace=True)
    assert goal.name == "Goal"


def test_without_a_volume_lattice_they_cannot_be_called():
    scenes.sphere()
    for name in ("squash_from_ground", "twist_from_bone", "bend_from_empty", "squash_from_speed"):
        assert not getattr(bpy.ops.isochor, name).poll()


def test_linked_objects_are_refused(tmp_path):
    ball_that_carries_its_lattice()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball"]
    ball = linked(bpy.data.objects["Ball"])
    ground = ground_object()
    scenes.choose(ball)
    bpy.context.view_layer.update()
    refused(bpy.ops.isochor.squash_from_ground, "“Ball” comes from another file", ground=ground.name)
    refused(bpy.ops.isochor.squash_from_speed, "“Ball” comes from another file")


def test_names_with_quotes_do_not_break_the_paths():
    ball, modifier = ball_that_carries_its_lattice()
    modifier.name = 'My "soft" \\ lattice'
    goal = empty_object("Goal", Vector((2.0, 0.0, 0.0)))
    select(ball, goal)
    assert bpy.ops.isochor.bend_from_empty() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert evaluated_input(ball, modifier, "Bend") > 0.5
    assert all(curve.driver.is_valid for curve in all_drivers())


@pytest.mark.parametrize(
    ("module", "name", "given"),
    [("squash_ground", "squash_from_ground", "ground"), ("twist_bone", "twist_from_bone", "armature")],
)
def test_a_target_that_the_selection_does_not_tell_is_asked_for(module, name, given, monkeypatch):
    ball, _modifier = ball_that_carries_its_lattice()
    select(ball)
    driving = scenes.part("ui.driving")
    asked = []

    def ask(operator, **_options):
        asked.append(operator)
        return {"RUNNING_MODAL"}

    manager = SimpleNamespace(invoke_props_dialog=ask)
    window = SimpleNamespace(window_manager=manager, view_layer=bpy.context.view_layer, object=ball)
    asks = getattr(scenes.part(f"ui.{module}"), f"ISOCHOR_OT_{name}").asks_for
    operator = SimpleNamespace(asks_for=asks, execute=lambda _context: {"FINISHED"}, **{given: ""})
    monkeypatch.setattr(driving, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    assert driving.Driving.invoke(operator, window, None) == {"RUNNING_MODAL"}
    assert asked == [operator]
    other = bpy.data.objects.new("Other", bpy.data.armatures.new("Other"))
    bpy.context.scene.collection.objects.link(other)
    other.select_set(True)
    assert driving.Driving.invoke(operator, window, None) == {"FINISHED"}
    other.select_set(False)
    setattr(operator, given, "Other")
    assert driving.Driving.invoke(operator, window, None) == {"FINISHED"}
