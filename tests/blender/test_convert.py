# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.convert: Volume Lattices in the place of Blender's own Lattice modifiers, with nothing visible changed."""

import bpy
import native_scenes
import numpy as np
import pytest
import scenes
from native_scenes import CLOSE, FRAMES

BSPLINE = ("KEY_BSPLINE",) * 3
MIXED = ("KEY_CARDINAL", "KEY_LINEAR", "KEY_CATMULL_ROM")


def animated(lattice: bpy.types.Object) -> None:
    """Keys the lattice's place, so that the mesh slides through it."""
    for frame, place in ((1, 0.0), (FRAMES, 0.4)):
        lattice.location = (place, -place, 0.5 * place)
        lattice.rotation_euler = (place, 0.0, place)
        lattice.keyframe_insert("location", frame=frame)
        lattice.keyframe_insert("rotation_euler", frame=frame)


def shapes(obj: bpy.types.Object) -> np.ndarray:
    """(frames, V, 3) what Blender draws of the object."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def converted(obj: bpy.types.Object, **properties) -> bpy.types.NodesModifier:
    scenes.choose(obj)
    assert bpy.ops.isochor.convert(**properties) == {"FINISHED"}
    assert all(modifier.type == "NODES" for modifier in obj.modifiers if "Lattice" in modifier.name)
    return next(modifier for modifier in obj.modifiers if modifier.type == "NODES")


def refused(obj: bpy.types.Object, **properties) -> str:
    """What it says; nothing has changed."""
    scenes.choose(obj)
    before = [(modifier.name, modifier.type, modifier.show_viewport) for modifier in obj.modifiers]
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.isochor.convert(**properties)
    assert [(modifier.name, modifier.type, modifier.show_viewport) for modifier in obj.modifiers] == before
    assert not bpy.data.node_groups
    return str(caught.value)


def test_a_shot_stays_as_it_was_with_its_keys_and_drivers_and_then_gains_its_volume():
    lattice = native_scenes.shaken((4, 3, 5), MIXED, 2.0)
    animated(lattice)
    ball = scenes.sphere()
    native_scenes.group(ball)
    modifier = native_scenes.native(ball, lattice, vertex_group="Part", invert_vertex_group=True, show_render=False)
    modifier.name = 'Squash "it"'
    for frame, strength in ((1, 1.0), (FRAMES, 0.3)):
        modifier.strength = strength
        modifier.keyframe_insert("strength", frame=frame)
    before = shapes(ball)
    assert native_scenes.apart(before[0], before[-1]) > 0.01
    ours = converted(ball)
    assert native_scenes.apart(shapes(ball), before) <= CLOSE
    assert (ours.name, ours.show_viewport, ours.show_render) == ('Squash "it"', True, False)
    inputs = {name: scenes.get_input(ours, name) for name in ("Basis", "Outside", "Vertex Group", "Invert")}
    assert inputs == {"Basis": "Blender", "Outside": "Extend", "Vertex Group": "Part", "Invert": True}
    assert scenes.get_input(ours, "Lattice") == lattice
    assert scenes.report(ball, ours).problems == ()
    scenes.set_input(ours, "Preserve", 1.0)
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


def test_a_driven_strength_follows_and_a_driver_that_reads_it_is_refused():
    lattice = native_scenes.shaken((3, 3, 3), BSPLINE)
    ball = scenes.sphere()
    modifier = native_scenes.native(ball, lattice)
    driver = modifier.driver_add("strength").driver
    driver.expression = "frame / 10"
    reader = scenes.lattice_object(2, name="Reader")
    other = reader.driver_add("location", 0).driver
    variable = other.variables.new()
    variable.name = "height"
    variable.targets[0].id, variable.targets[0].data_path = ball, 'modifiers["Lattice"].strength'
    other.expression = "height * 2"
    before = shapes(ball)
    assert native_scenes.apart(before[0], before[-1]) > 0.01
    assert "Drivers read the strength" in refused(ball)
    reader.driver_remove("location", 0)
    ours = converted(ball)
    assert native_scenes.apart(shapes(ball), before) <= CLOSE
    bpy.context.scene.frame_set(4)
    shown = ball.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers[ours.name]
    assert scenes.get_input(shown, "Strength") == pytest.approx(0.4, abs=1e-6)


def test_keys_of_a_switch_stay():
    ball = scenes.sphere()
    modifier = native_scenes.native(ball, native_scenes.shaken((3, 3, 3), BSPLINE))
    for frame, shown in ((1, True), (3, False)):
        modifier.show_viewport = shown
        modifier.keyframe_insert("show_viewport", frame=frame)
    before = shapes(ball)
    converted(ball)
    assert native_scenes.apart(shapes(ball), before) <= CLOSE
    assert np.array_equal(shapes(ball)[-1], scenes.positions(ball.data))


def test_several_objects_several_modifiers_and_one_undo():
    lattice, second = native_scenes.shaken((3, 4, 3), BSPLINE), native_scenes.shaken((2, 2, 5), MIXED, 2.8, seed=8)
    balls = [scenes.sphere(name=name) for name in ("One", "Two")]
    for ball in balls:
        native_scenes.native(ball, lattice).name = "First"
        native_scenes.native(ball, second).name = "Second"
        ball.modifiers.new("Subdivision", "SUBSURF")
        ball.modifiers.move(2, 0)
    bpy.context.view_layer.update()
    before = [scenes.evaluated_positions(ball) for ball in balls]
    bpy.ops.ed.undo_push()
    scenes.choose(lattice)
    assert bpy.ops.isochor.convert() == {"FINISHED"}
    bpy.ops.ed.undo_push()
    for ball, shape in zip(balls, before, strict=True):
        assert [modifier.type for modifier in ball.modifiers] == ["SUBSURF", "NODES", "NODES"]
        assert ball.modifiers.keys() == ["Subdivision", "First", "Second"]
        assert native_scenes.apart(scenes.evaluated_positions(ball), shape) <= CLOSE
    bpy.ops.ed.undo()
    assert [modifier.type for modifier in bpy.data.objects["One"].modifiers] == ["SUBSURF", "LATTICE", "LATTICE"]


def test_only_the_active_one_and_preserve_at_once():
    lattice = native_scenes.shaken((3, 4, 3), BSPLINE)
    ball = scenes.sphere()
    for name in ("First", "Second"):
        native_scenes.native(ball, lattice).name = name
    ball.modifiers.active = ball.modifiers["Second"]
    scenes.choose(ball)
    assert bpy.ops.isochor.convert(only_active=True, preserve=True) == {"FINISHED"}
    assert [(one.name, one.type) for one in ball.modifiers] == [("First", "LATTICE"), ("Second", "NODES")]
    assert ball.modifiers.active.name == "Second"
    assert scenes.get_input(ball.modifiers["Second"], "Preserve") == 1.0
    ball.modifiers["First"].show_viewport = False
    whole = scenes.report(ball, ball.modifiers["Second"]).volumes.target
    assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6


def test_a_lattice_with_a_group_of_its_own_and_one_that_is_off_or_hidden():
    lattice = native_scenes.shaken((4, 4, 4), BSPLINE)
    native_scenes.group(lattice, "Own")
    lattice.data.vertex_group = "Own"
    lattice.hide_viewport = True
    ball = scenes.sphere()
    native_scenes.native(ball, lattice)
    native_scenes.native(ball, lattice, show_viewport=False).name = "Off"
    before = shapes(ball)
    converted(ball)
    assert native_scenes.apart(shapes(ball), before) <= CLOSE
    assert not ball.modifiers["Off"].show_viewport
    ball.modifiers["Off"].show_viewport = True
    bpy.context.view_layer.update()
    assert native_scenes.apart(scenes.evaluated_positions(ball), before[-1]) > 0.001


def test_refusals():
    lattice = native_scenes.shaken((3, 3, 3), BSPLINE)
    ball = scenes.sphere()
    modifier = native_scenes.native(ball, None)
    assert "has no lattice" in refused(ball)
    modifier.object, modifier.strength = lattice, 1.5
    assert "below 0 or above 1" in refused(ball)
    modifier.strength = 1.0
    ball.modifiers.new("Cast", "CAST")
    native_scenes.native(ball, lattice).name = "After"
    assert "Cast stands between" in refused(ball)
    ball.modifiers.remove(ball.modifiers["After"])
    modifier.keyframe_insert("strength", frame=1)
    other = ball.copy()
    bpy.context.scene.collection.objects.link(other)
    assert other.animation_data.action == ball.animation_data.action
    assert "animates others too" in refused(ball)
    bpy.data.objects.remove(other)
    curve = scenes.linked(bpy.data.objects.new("Curve", bpy.data.curves.new("Curve", "CURVE")))
    native_scenes.native(curve, lattice)
    assert "no mesh" in refused(curve)
    bpy.data.objects.remove(curve)
    scenes.choose(ball)
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Object Mode"):
        bpy.ops.isochor.convert()
    bpy.ops.object.mode_set(mode="OBJECT")
    converted(ball)


def test_what_ours_cannot_deform_is_left_as_it_was():
    ball = scenes.sphere()
    modifier = native_scenes.native(ball, native_scenes.shaken((3, 3, 3), BSPLINE), strength=0.6)
    modifier.keyframe_insert("strength", frame=1)
    ball.modifiers.new("Remesh", "REMESH")
    ball.modifiers.new("Cast", "CAST")
    ball.modifiers.move(2, 0)
    bpy.context.view_layer.update()
    before = scenes.evaluated_positions(ball)
    assert "replaces the vertices" in refused(ball)
    assert np.array_equal(scenes.evaluated_positions(ball), before)
    curves = scenes.part("tool.animation_paths").curves_at(ball, 'modifiers["Lattice"].strength')
    assert len(curves) == 1


def test_poll_says_what_to_select():
    ball = scenes.sphere()
    scenes.choose(ball)
    assert not bpy.ops.isochor.convert.poll()


def test_a_linked_object_is_refused(tmp_path):
    ball = scenes.sphere()
    native_scenes.native(ball, native_scenes.shaken((3, 3, 3), BSPLINE))
    place = str(tmp_path / "linked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    scenes.choose(here.objects[0])
    with pytest.raises(RuntimeError, match="comes from another file"):
        bpy.ops.isochor.convert()
