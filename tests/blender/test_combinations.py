# SPDX-License-Identifier: GPL-3.0-or-later
"""Features met together: binding, jelly, bakes, overrides, loops and copies on the same object."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import bpy
import elsewhere
import numpy as np
import pytest
import scenes
from numpy.typing import NDArray
from test_bake import Window
from test_set_rest import bent_lattice

FRAMES = 6
ALL = range(1, FRAMES + 1)
FORMATS = ["PC2", "MDD", "SHAPE_KEYS", "LATTICE"]
TABLES = ("objects", "meshes", "lattices", "actions", "shape_keys", "node_groups")
Array = NDArray[np.float64]


def counts() -> dict[str, int]:
    """How many of everything that the add-on makes is in the file."""
    return {kind: len(getattr(bpy.data, kind)) for kind in TABLES}


def shapes(obj: bpy.types.Object, frames: range = ALL) -> Array:
    """(F, V, 3) what Blender draws of the object in these frames."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def computed_anew(obj: bpy.types.Object) -> Array:
    """The same with nothing remembered."""
    scenes.part("tool.handlers").recompute()
    bpy.context.view_layer.update()
    return shapes(obj)


def require_loops(obj: bpy.types.Object) -> None:
    """However often it is played, each frame is what it is when it is computed alone."""
    rounds = [shapes(obj) for _round in range(4)]
    wanted = computed_anew(obj)
    assert np.abs(np.array(rounds) - wanted).max() <= 2e-6


def worst_volume(obj: bpy.types.Object, found: Array) -> float:
    """Largest relative error of the volume in float64 over these shapes."""
    whole = scenes.volume(obj.data)
    return max(abs(elsewhere.volume(shape, obj) / whole - 1.0) for shape in found)


def shaking() -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.NodesModifier]:
    """A ball, and a lattice that a keyed shape key squashes and shears."""
    ball = scenes.sphere(16, 10)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    lattice = scenes.lattice_object(4, size=3.4, name="Cage")
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash", from_mix=False)
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.3 * z + 0.1, y + 0.15 * x * z, 0.5 * z + 0.1 * x * y)
    for frame, value in ((1, 0.0), (3, 1.0), (FRAMES, 0.3)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_set(1)
    modifier = scenes.volume_lattice(ball, lattice)
    scenes.choose(ball)
    return ball, lattice, modifier


def key_input(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str, values: dict[int, float]) -> None:
    path = scenes.part("tool.drivers").data_path(modifier, name)
    for frame, value in values.items():
        scenes.set_input(modifier, name, value)
        obj.keyframe_insert(path, frame=frame)


def bake(kind: str, folder: Path) -> set[str]:
    return bpy.ops.isochor.bake(format=kind, **({"directory": str(folder)} if kind in ("PC2", "MDD") else {}))


def refused(operator: str, words: str, **properties: object) -> None:
    """The operator refuses with these words, and changes nothing."""
    before = counts()
    with pytest.raises(RuntimeError, match=words):
        getattr(bpy.ops.isochor, operator)("EXEC_DEFAULT", True, **properties)
    assert counts() == before


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("rest", ["none", "plain", "shaped"])
@pytest.mark.parametrize("jelly", [False, True])
def test_bound_jelly_with_a_keyed_twist_is_baked_freed_baked_again_and_removed(tmp_path, kind, rest, jelly):
    ball, lattice, modifier = shaking()
    key_input(ball, modifier, "Twist", {1: 0.0, FRAMES: 1.2})
    if jelly:
        assert bpy.ops.isochor.simulate("EXEC_DEFAULT", True) == {"FINISHED"}
    if rest != "none":
        bpy.context.scene.frame_set(1 if rest == "plain" else 3)
        assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    for frame, far in ((1, 0.0), (FRAMES, 0.6)):
        lattice.location.x = lattice.rotation_euler.z = far
        lattice.keyframe_insert("location", frame=frame)
        lattice.keyframe_insert("rotation_euler", frame=frame)
    before, seen = counts(), shapes(ball)
    assert np.ptp(seen, axis=0).max() > 0.1
    assert worst_volume(ball, seen) <= 1e-6
    if kind == "LATTICE" and rest == "shaped":
        refused("bake", "already shaped", format=kind)
        return
    assert bake(kind, tmp_path) == {"FINISHED"}
    played = shapes(ball)
    assert np.abs(played - seen).max() <= 4e-6
    assert worst_volume(ball, played) <= 1.5e-6
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert counts() == before
    assert np.abs(shapes(ball) - seen).max() <= 2e-6
    assert bake(kind, tmp_path) == {"FINISHED"}
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not ball.modifiers
    assert not list(ball.keys())
    assert ball.data.shape_keys is None
    assert (shapes(ball) == scenes.positions(ball.data)).all()


def test_shape_keys_of_a_loop_with_a_moving_mesh_are_those_of_each_frame():
    ball, lattice, _modifier = shaking()
    ball.shape_key_add(name="Basis")
    wide = ball.shape_key_add(name="Wide", from_mix=False)
    for point in wide.data:
        point.co.x *= 1.2
    lattice.data.shape_keys.animation_data_clear()
    squash = lattice.data.shape_keys.key_blocks["Squash"]
    for frame in range(1, 13):
        for key, value in ((wide, float(frame % 2)), (squash, 0.5 * (frame % 2))):
            key.value = value
            key.keyframe_insert("value", frame=frame)
    seen = shapes(ball, range(1, 13))
    assert bpy.ops.isochor.bake(format="SHAPE_KEYS", frame_start=1, frame_end=12) == {"FINISHED"}
    assert np.abs(shapes(ball, range(1, 13)) - seen).max() <= 4e-6


def test_a_native_lattice_of_a_loop_has_place_and_strength_of_each_frame():
    ball, lattice, modifier = shaking()
    lattice.data.shape_keys.animation_data_clear()
    squash = lattice.data.shape_keys.key_blocks["Squash"]
    key_input(ball, modifier, "Strength", {frame: 0.4 + 0.5 * (frame % 2) for frame in range(1, 13)})
    for frame in range(1, 13):
        lattice.location.x = 0.2 * (frame % 2)
        lattice.keyframe_insert("location", frame=frame)
        squash.value = 0.2 + 0.5 * (frame % 2)
        squash.keyframe_insert("value", frame=frame)
    seen = shapes(ball, range(1, 13))
    assert bpy.ops.isochor.bake(format="LATTICE", frame_start=1, frame_end=12) == {"FINISHED"}
    assert np.abs(shapes(ball, range(1, 13)) - seen).max() <= 4e-6


def test_the_volume_curve_of_frames_that_are_remembered_is_that_of_each_frame():
    ball, _lattice, modifier = shaking()
    ball.shape_key_add(name="Basis")
    wide = ball.shape_key_add(name="Wide", from_mix=False)
    for point in wide.data:
        point.co.x *= 1.5
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)
    scenes.set_input(modifier, "Reference", "Incoming")
    volume_curve = scenes.part("tool.volume_curve")
    assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    first = volume_curve.read(modifier)
    assert np.ptp(first.target) > 0.1
    for _round in range(3):
        shapes(ball)
    assert len(scenes.part("tool.frame_memory")._frames) == FRAMES
    assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    again = volume_curve.read(modifier)
    for name in ("target", "before", "after"):
        assert getattr(again, name) == pytest.approx(getattr(first, name), rel=1e-6)


def test_no_change_between_loops_leaves_a_stale_frame():
    ball, lattice, modifier = shaking()
    require_loops(ball)
    bpy.context.scene.frame_set(3)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    require_loops(ball)
    assert bpy.ops.isochor.clear_rest() == {"FINISHED"}
    require_loops(ball)
    group = ball.vertex_groups.new(name="Part")
    scenes.set_input(modifier, "Vertex Group", "Part")
    for weight in (0.3, 0.9):
        group.add(list(range(40)), weight, "REPLACE")
        ball.data.update()
        require_loops(ball)
    group.add(list(range(162)), 1.0, "REPLACE")
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Wide", from_mix=False)
    for value in (0.5, 0.8):
        for point in key.data:
            point.co.x *= 1.2
        key.value = value
        require_loops(ball)
    lattice.location.x += 0.1
    require_loops(ball)
    preferences = scenes.part("tool.device").of_user()
    for name, values in (("precision", ("DOUBLE", "SINGLE")), ("device", ("CPU", "AUTO"))):
        for value in values:
            setattr(preferences, name, value)
            require_loops(ball)


def test_no_change_of_an_armature_leaves_a_stale_frame():
    ball = scenes.sphere(16, 10)
    bpy.context.scene.frame_end = FRAMES
    rig = scenes.linked(bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig")))
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, -1), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = ball.vertex_groups.new(name="Bone")
    group.add(list(range(80)), 1.0, "REPLACE")
    armature = ball.modifiers.new("Armature", "ARMATURE")
    armature.object = rig
    scenes.volume_lattice(ball, scenes.lattice_object(4, size=3.4))
    pose = rig.pose.bones["Bone"]
    pose.rotation_mode = "XYZ"
    for axis, turn in ((2, 0.8), (0, -0.9)):
        for frame, angle in ((1, 0.0), (FRAMES, turn)):
            pose.rotation_euler[axis] = angle
            pose.keyframe_insert("rotation_euler", frame=frame)
        require_loops(ball)
    assert worst_volume(ball, shapes(ball)) <= 1e-6
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    require_loops(ball)
    group.add(list(range(40)), 0.5, "REPLACE")
    ball.data.update()
    require_loops(ball)
    for shown in (False, True):
        armature.show_viewport = shown
        require_loops(ball)


def dropped(bound: bool, basis: str, away: float = 0.0) -> Array:
    """(F, V, 3) in the world: a tilted ball let go, its lattice bound or not and then moved away."""
    scenes.empty_file()
    ball = scenes.sphere(16, 10)
    ball.location, ball.rotation_euler = (0.5, 0.2, 1.6), (0.3, 0.2, 0.1)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 20
    bpy.context.view_layer.update()
    bpy.ops.isochor.add(basis=basis)
    if bound:
        assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    scenes.get_input(ball.modifiers.active, "Lattice").location.x += away
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.simulate("EXEC_DEFAULT", True) == {"FINISHED"}
    found = shapes(ball, range(1, 21))
    assert worst_volume(ball, found) <= 1e-6
    matrix = np.array(ball.matrix_world)
    return found @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("basis", ["BERNSTEIN", "BSPLINE"])
def test_jelly_of_a_bound_mesh_falls_as_that_of_one_not_bound_from_where_the_lattice_is(basis):
    plain = dropped(False, basis)
    assert np.ptp(plain[:, :, 2]) > 2.0, "it does not fall"
    assert np.abs(dropped(True, basis) - plain).max() <= 1e-5
    assert np.abs(dropped(True, basis, away=2.0) - plain - (2.0, 0.0, 0.0)).max() <= 1e-4


def test_jelly_refuses_a_rest_that_was_shaped_and_editing_refuses_jelly():
    ball = scenes.sphere(16, 10)
    lattice = scenes.lattice_object(4, size=4.5)
    scenes.volume_lattice(ball, lattice)
    bent_lattice(lattice)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    refused("simulate", "already shaped when the rest of “Ball” was set")
    assert bpy.ops.isochor.clear_rest() == {"FINISHED"}
    bpy.context.scene.frame_end = FRAMES
    assert bpy.ops.isochor.simulate("EXEC_DEFAULT", True) == {"FINISHED"}
    refused("fit_lattice", "shows a simulation")
    refused("mirror_lattice", "shows a simulation")


@pytest.mark.parametrize("kind", FORMATS)
def test_while_a_bake_plays_what_would_not_be_seen_is_refused(tmp_path, kind):
    shaking()
    assert bake(kind, tmp_path) == {"FINISHED"}
    for operator in ("simulate", "set_rest", "fit_lattice", "apply"):
        refused(operator, "“Ball” plays a bake")


@pytest.mark.parametrize("operator", ["simulate", "measure_volume"])
def test_what_takes_long_tells_how_far_it_is_in_a_window_and_esc_leaves_nothing(operator, monkeypatch):
    ball, lattice, modifier = shaking()
    bpy.context.scene.frame_set(2)
    kind = getattr(bpy.types, f"ISOCHOR_OT_{operator}")
    stepping = scenes.part("ui.stepping")
    monkeypatch.setattr(stepping, "PATIENCE_S", 0.0)
    before, own = counts(), lattice.data

    class Running(stepping.Stepping):
        """The operator's own steps and end, in a window that is none."""

        how_far, finished, _broken_off = kind.how_far, kind.finished, kind._broken_off

        def report(self, _kind: set[str], text: str) -> None:
            said.append(text)

    for esc_after in (3, None):
        said: list[str] = []
        running, window = Running(), Window()
        running._with_progress = True
        running._frames, running._pairs = ALL, [(ball, modifier)]
        scene, layer = bpy.context.scene, bpy.context.view_layer
        if operator == "measure_volume":
            work = scenes.part("tool.volume_curve").measure(scene, layer, [(ball, modifier)], ALL)
        else:
            running.as_kept, running._one = dict, lambda _context, _lattice, shapes: shake(shapes)
            work = kind._simulated(running, bpy.context, [lattice])
        assert running.run(window, work) == {"RUNNING_MODAL"}
        ticks = 0
        ended = {"RUNNING_MODAL"}
        while ended == {"RUNNING_MODAL"}:
            esc = ticks == esc_after
            event = SimpleNamespace(type="ESC" if esc else "TIMER", value="PRESS" if esc else "NOTHING")
            ended = running.modal(window, event)
            ticks += 1
        assert window.timers == 0
        assert window.texts[0].endswith(("Esc: break off", "nothing is changed"))
        assert window.texts[-1] is None
        assert scene.frame_current == 2
        if esc_after is not None:
            assert ended == {"CANCELLED"}
            assert said == ["Broken off: nothing was kept"]
            assert counts() == before
            assert lattice.data == own
    assert ended == {"FINISHED"}
    done = scenes.part("tool.volume_curve").read(modifier) if operator == "measure_volume" else lattice.data != own
    assert done


def shake(shapes: SimpleNamespace) -> Iterator[float]:
    """In place of a simulation: two frames of shapes, in five steps."""
    shapes.first, shapes.points = 1, [np.zeros(192, np.float32), np.ones(192, np.float32)]
    for step in range(5):
        bpy.context.scene.frame_set(step + 3)
        yield step / 5


def test_a_simulation_whose_modifier_is_gone_can_be_freed():
    _ball, lattice, _modifier = shaking()
    own, before = lattice.data, counts()
    assert bpy.ops.isochor.simulate("EXEC_DEFAULT", True) == {"FINISHED"}
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    scenes.choose(lattice)
    assert bpy.ops.isochor.free_simulation() == {"FINISHED"}
    assert lattice.data == own
    assert counts()["lattices"] == before["lattices"]
    assert counts()["actions"] == before["actions"]


@pytest.mark.parametrize("kind", FORMATS)
def test_a_bake_whose_modifier_was_deleted_by_hand_can_be_freed(tmp_path, kind):
    ball, _lattice, modifier = shaking()
    assert bake(kind, tmp_path) == {"FINISHED"}
    ball.modifiers.remove(modifier)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert not ball.modifiers
    assert not list(ball.keys())
    assert (shapes(ball) == scenes.positions(ball.data)).all()


@pytest.mark.parametrize("kind", ["PC2", "SHAPE_KEYS"])
def test_of_two_whose_bake_plays_one_is_removed_and_the_other_goes_on(tmp_path, kind):
    ball, _lattice, first = shaking()
    second_lattice = scenes.lattice_object(3, size=3.8, name="Second")
    second = scenes.volume_lattice(ball, second_lattice)
    second_lattice.rotation_euler.z = 0.3
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    second_lattice.location.x = 0.5
    require_loops(ball)
    both = shapes(ball)
    assert worst_volume(ball, both) <= 1e-6
    second.show_viewport = False
    scenes.set_input(first, "Preserve", 1.0)
    alone = shapes(ball)
    scenes.set_input(first, "Preserve", 0.0)
    second.show_viewport = True
    assert bake(kind, tmp_path) == {"FINISHED"}
    assert np.abs(shapes(ball) - both).max() <= 4e-6
    ball.modifiers.active = second
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert list(ball.modifiers) == [first]
    assert first.show_viewport
    assert first.show_render
    assert not list(ball.keys())
    assert np.abs(shapes(ball) - alone).max() <= 2e-6


@pytest.mark.parametrize("kind", ["PC2", "SHAPE_KEYS", "LATTICE"])
def test_a_copy_of_what_plays_a_bake_is_freed_and_removed_alone(tmp_path, kind):
    ball, _lattice, _modifier = shaking()
    before, seen = counts(), shapes(ball)
    assert bake(kind, tmp_path) == {"FINISHED"}
    bpy.ops.object.duplicate("EXEC_DEFAULT", linked=False)
    copy = bpy.context.active_object
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert np.abs(shapes(copy) - seen).max() <= 2e-6
    assert np.abs(shapes(ball) - seen).max() <= 4e-6
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    mesh = copy.data
    bpy.data.objects.remove(copy)
    bpy.data.meshes.remove(mesh)
    scenes.choose(ball)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert np.abs(shapes(ball) - seen).max() <= 2e-6
    after = counts()
    # Blender 4.5 counts one user too many of a duplicated mesh's keys, and so keeps them.
    assert {**after, "shape_keys": 0} == {**before, "shape_keys": 0}


def test_undo_goes_back_through_jelly_rest_bake_and_removal_and_redo_forth():
    ball, _lattice, _modifier = shaking()
    bpy.ops.ed.undo_push(message="start")
    steps = (("simulate", {}), ("set_rest", {}), ("bake", {"format": "SHAPE_KEYS"}), ("remove", {}))
    passed = []
    for operator, properties in steps:
        scenes.choose(bpy.data.objects["Ball"])
        passed.append((counts(), shapes(bpy.data.objects["Ball"])))
        bpy.context.scene.frame_set(3)
        assert getattr(bpy.ops.isochor, operator)("EXEC_DEFAULT", True, **properties) == {"FINISHED"}
    for number, (_operator, _properties) in reversed(list(enumerate(steps))[1:]):
        bpy.ops.ed.undo()
        ball = bpy.data.objects["Ball"]
        assert counts() == passed[number][0]
        assert np.abs(shapes(ball) - passed[number][1]).max() <= 4e-6
    for _step in steps[1:]:
        bpy.ops.ed.redo()
    ball = bpy.data.objects["Ball"]
    assert not ball.modifiers
    assert not list(ball.keys())


def override(tmp_path: Path) -> bpy.types.Object:
    """The ball as a library override, in a collection that is one too."""
    ball, lattice, _modifier = shaking()
    collection = bpy.data.collections.new("Character")
    bpy.context.scene.collection.children.link(collection)
    for obj in (ball, lattice):
        bpy.context.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    library = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library)
    scenes.empty_file()
    bpy.context.scene.frame_end = FRAMES
    with bpy.data.libraries.load(library, link=True) as (_found, wanted):
        wanted.collections = ["Character"]
    linked = wanted.collections[0]
    bpy.context.scene.collection.children.link(linked)
    linked.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, do_fully_editable=True)
    bpy.context.view_layer.update()
    ball = own_ball()
    scenes.choose(ball)
    return ball


def own_ball() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.name == "Ball" and obj.library is None)


def reloaded(tmp_path: Path) -> bpy.types.Object:
    place = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    ball = own_ball()
    scenes.choose(ball)
    return ball


@pytest.mark.parametrize("kind", ["PC2", "LATTICE"])
def test_the_bake_of_an_override_is_freed_after_loading(tmp_path, kind):
    ball = override(tmp_path)
    seen = shapes(ball)
    assert bake(kind, tmp_path) == {"FINISHED"}
    ball = reloaded(tmp_path)
    assert np.abs(shapes(ball) - seen).max() <= 4e-6
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert [modifier.type for modifier in ball.modifiers] == ["NODES"]
    assert ball.modifiers[0].show_viewport
    assert ball.modifiers[0].show_render
    assert np.abs(shapes(ball) - seen).max() <= 2e-6
    assert not bpy.ops.isochor.free_bake.poll()


def test_a_lattice_added_to_an_override_is_baked_loaded_and_removed(tmp_path):
    ball = override(tmp_path)
    theirs = ball.modifiers[0]
    theirs.show_viewport = theirs.show_render = False
    assert bpy.ops.isochor.add(resolution=(3, 3, 3)) == {"FINISHED"}
    ours = ball.modifiers.active
    for point in scenes.get_input(ours, "Lattice").data.points:
        point.co_deform.x *= 1.5
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    scenes.get_input(ours, "Lattice").scale.z *= 0.5
    bpy.context.view_layer.update()
    seen = shapes(ball)
    assert worst_volume(ball, seen) <= 1e-6
    assert bake("PC2", tmp_path) == {"FINISHED"}
    ball = reloaded(tmp_path)
    assert np.abs(shapes(ball) - seen).max() <= 2e-6
    ball.modifiers.active = ball.modifiers[1]
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert [modifier.type for modifier in ball.modifiers] == ["NODES"]
    assert not ball.modifiers[0].show_viewport


def test_in_a_collection_that_is_an_override_new_objects_go_elsewhere(tmp_path):
    ball = override(tmp_path)
    layers = bpy.context.view_layer.layer_collection.children
    theirs = next(layer for layer in layers if layer.collection.override_library is not None)
    bpy.context.view_layer.active_layer_collection = theirs
    assert bpy.ops.isochor.bend_from_empty() == {"FINISHED"}
    assert bpy.data.objects["Ball Bend"].users_collection[0] == bpy.context.scene.collection
    scenes.choose(ball)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    lattice = scenes.get_input(ball.modifiers.active, "Lattice")
    assert lattice.users_collection[0] == bpy.context.scene.collection


def test_an_override_keeps_no_speed_so_that_is_refused(tmp_path):
    override(tmp_path)
    refused("squash_from_speed", "is a library override")


@pytest.mark.parametrize("read_elsewhere", [False, True])
def test_the_speed_goes_with_the_last_volume_lattice_unless_something_else_reads_it(read_elsewhere):
    ball, _lattice, _modifier = shaking()
    for frame, place in ((1, 0.0), (3, 4.0), (FRAMES, 5.0)):
        ball.location.z = place
        ball.keyframe_insert("location", frame=frame)
    assert bpy.ops.isochor.squash_from_speed() == {"FINISHED"}
    if read_elsewhere:
        driver = ball.driver_add("scale", 0).driver
        variable = driver.variables.new()
        variable.targets[0].id, variable.targets[0].data_path = ball, '["isochor_speed"]'
        driver.expression = variable.name
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert ("isochor_speed" in ball) == read_elsewhere
    curve = scenes.part("tool.drivers").keys_of(ball, '["isochor_speed"]')
    assert (curve is not None) == read_elsewhere
    assert scenes.part("tool.drivers").keys_of(ball, "location") is not None


@pytest.mark.parametrize("mode", ["Viewport", "Render"])
def test_a_result_that_an_undo_mixed_up_with_the_mesh_itself_is_made_anew_and_the_mesh_kept(mode):
    ball, _lattice, modifier = shaking()
    own, seen = scenes.positions(ball.data), shapes(ball)
    scenes.set_input(modifier, f"{mode} Result", ball)
    bpy.context.view_layer.update()
    assert np.abs(shapes(ball) - seen).max() <= 2e-6
    assert (scenes.positions(ball.data) == own).all()
    result = scenes.get_input(modifier, f"{mode} Result")
    assert result.name.startswith(".")
    assert result.data != ball.data
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert (shapes(ball) == own).all()


def test_a_lattice_that_a_redo_mixed_up_with_the_mesh_itself_is_found_again():
    """Blender does so where memory happens to lie so; here the mix-up is made between its redo and our handler."""
    scenes.sphere()
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.add("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()

    def mix_up(*_arguments: object) -> None:
        ball = bpy.data.objects["Ball"]
        scenes.set_input(ball.modifiers[0], "Lattice", ball)

    bpy.app.handlers.redo_post.insert(0, mix_up)
    try:
        bpy.ops.ed.redo()
    finally:
        bpy.app.handlers.redo_post.remove(mix_up)
    ball = bpy.data.objects["Ball"]
    assert scenes.get_input(ball.modifiers[0], "Lattice") == bpy.data.objects["Ball Lattice"]
    bpy.data.objects["Ball Lattice"].data.points[0].co_deform.x -= 1.0
    bpy.context.view_layer.update()
    assert (scenes.evaluated_positions(ball) != scenes.positions(ball.data)).any()
    assert worst_volume(ball, scenes.evaluated_positions(ball)[None]) <= 1e-6
