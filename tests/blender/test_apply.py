# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.apply: the shape shown becomes the mesh's own or a shape key, and nothing of ours stays behind."""

import bpy
import numpy as np
import pytest
import scenes


def squashed_ball(name: str = "Ball", factor: float = 0.5) -> bpy.types.Object:
    """A ball in a squashed lattice that isochor.add made."""
    ball = scenes.sphere(name=name)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    squash(bpy.data.objects[f"{name} Lattice"], factor)
    return ball


def squash(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def nothing_of_ours_is_left() -> bool:
    left = [*bpy.data.lattices, *bpy.data.node_groups, *bpy.data.actions]
    left += [obj for obj in bpy.data.objects if obj.name.startswith(".")]
    left += [mesh for mesh in bpy.data.meshes if mesh.name.startswith(".")]
    return not left


def key_positions(obj: bpy.types.Object, name: str) -> np.ndarray:
    return np.array([tuple(point.co) for point in obj.data.shape_keys.key_blocks[name].points], np.float64)


def refused(words: str, **settings) -> None:
    """Applying raises an error with these words and changes nothing."""
    before = {obj.name: [modifier.name for modifier in obj.modifiers] for obj in bpy.data.objects}
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.isochor.apply(**settings)
    assert before == {obj.name: [modifier.name for modifier in obj.modifiers] for obj in bpy.data.objects}


def test_the_mesh_takes_exactly_the_shape_shown_and_nothing_of_ours_stays():
    ball = squashed_ball()
    shown, whole = scenes.evaluated_positions(ball), scenes.volume(ball.data)
    assert np.ptp(shown[:, 2]) < 1.5
    assert bpy.ops.isochor.apply() == {"FINISHED"}
    assert np.array_equal(scenes.positions(ball.data), shown)
    assert abs(scenes.volume(ball.data) / whole - 1) <= 1e-6
    assert not ball.modifiers
    assert not [found for found in ball.data.attributes if "isochor" in found.name]
    assert nothing_of_ours_is_left()
    bpy.context.scene.frame_set(3)
    assert np.array_equal(scenes.evaluated_positions(ball), shown)


def test_applying_is_one_undo_step():
    ball = squashed_ball()
    shown, own = scenes.evaluated_positions(ball), scenes.positions(ball.data)
    bpy.ops.ed.undo_push(message="squashed")
    bpy.ops.isochor.apply("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    bpy.context.view_layer.update()
    assert np.array_equal(scenes.positions(ball.data), own)
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    assert bpy.data.objects["Ball Lattice"]
    bpy.ops.ed.redo()
    ball = bpy.data.objects["Ball"]
    assert np.array_equal(scenes.positions(ball.data), shown)
    assert not ball.modifiers


def test_a_picked_lattice_stays():
    ball = scenes.sphere()
    lattice = scenes.lattice_object()
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    bpy.ops.isochor.apply()
    assert lattice.name in bpy.context.scene.objects
    assert not ball.modifiers


def test_as_shape_key_at_one_shows_the_same_and_the_basis_stays():
    ball = squashed_ball()
    shown, own = scenes.evaluated_positions(ball), scenes.positions(ball.data)
    ball.modifiers[0].name = "Squashed"
    assert bpy.ops.isochor.apply(as_shape_key=True) == {"FINISHED"}
    keys = ball.data.shape_keys.key_blocks
    assert [key.name for key in keys] == ["Basis", "Squashed"]
    assert keys["Squashed"].value == 1.0
    assert np.array_equal(key_positions(ball, "Basis"), own)
    assert np.array_equal(key_positions(ball, "Squashed"), shown)
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    assert not ball.modifiers
    assert nothing_of_ours_is_left()
    keys["Squashed"].value = 0.0
    assert np.array_equal(scenes.evaluated_positions(ball), own)


def test_as_shape_key_on_top_of_keys_that_are_there():
    ball = scenes.sphere()
    ball.shape_key_add(name="Basis")
    fat = ball.shape_key_add(name="Fat", from_mix=False)
    for point in fat.points:
        point.co.x *= 1.2
    fat.value = 0.7
    bpy.ops.isochor.add()
    squash(bpy.data.objects["Ball Lattice"])
    shown = scenes.evaluated_positions(ball)
    fat_before = key_positions(ball, "Fat")
    assert bpy.ops.isochor.apply(as_shape_key=True) == {"FINISHED"}
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    assert np.array_equal(key_positions(ball, "Fat"), fat_before)
    assert np.isclose(fat.value, 0.7)
    ball.data.shape_keys.key_blocks["Volume Lattice"].value = 0.0
    own = scenes.positions(ball.data)
    widened = own * (1 + 0.2 * 0.7, 1, 1)
    assert np.abs(scenes.evaluated_positions(ball) - widened).max() < 1e-6


def test_keep_modifier_switches_it_off_so_that_the_object_looks_the_same():
    ball = squashed_ball()
    shown = scenes.evaluated_positions(ball)
    bpy.ops.isochor.apply(as_shape_key=True, keep_modifier=True)
    modifier = ball.modifiers[0]
    assert not modifier.show_viewport
    assert not modifier.show_render
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    ball.data.shape_keys.key_blocks["Volume Lattice"].value = 0.0
    modifier.show_viewport = True
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6


def test_shape_keys_refuse_a_new_mesh_as_blender_does():
    ball = scenes.sphere()
    ball.shape_key_add(name="Basis")
    bpy.ops.isochor.add()
    refused("has shape keys, which a new shape would contradict: apply as shape key")
    ball.data.shape_keys.use_relative = False
    refused("are absolute", as_shape_key=True)
    ball.data.shape_keys.use_relative = True
    ball.show_only_shape_key = True
    refused("turn Solo off", as_shape_key=True)


@pytest.mark.parametrize("operator", ["apply", "remove"])
def test_keys_and_drivers_of_its_inputs_go_with_it_and_no_others(operator):
    ball = squashed_ball()
    modifier = ball.modifiers[0]
    sockets = scenes.part("tool.sockets")
    path = f'modifiers["{modifier.name}"]'
    joined = "." if sockets.data_path(modifier, "Target").startswith("p") else ""
    ball.keyframe_insert(f"{path}{joined}{sockets.data_path(modifier, 'Target')}", frame=1)
    ball.driver_add(f"{path}{joined}{sockets.data_path(modifier, 'Strength')}").driver.expression = "1"
    ball.keyframe_insert(f"{path}.show_render", frame=1)
    other = ball.modifiers.new("Volume Lattice 2", "DISPLACE")
    other.strength = 0.0
    other.keyframe_insert("strength", frame=1)
    other.driver_add("mid_level")
    ball.keyframe_insert("location", frame=1)
    ball.modifiers.active = modifier
    bpy.context.view_layer.update()
    assert getattr(bpy.ops.isochor, operator)() == {"FINISHED"}
    bag = ball.animation_data.action.layers[0].strips[0].channelbag(ball.animation_data.action_slot)
    assert {curve.data_path for curve in bag.fcurves} == {"location", 'modifiers["Volume Lattice 2"].strength'}
    assert [driver.data_path for driver in ball.animation_data.drivers] == ['modifiers["Volume Lattice 2"].mid_level']


def test_an_action_that_held_nothing_else_goes_too():
    ball = squashed_ball()
    ball.modifiers[0].keyframe_insert("show_render", frame=1)
    assert bpy.data.actions
    bpy.ops.isochor.apply()
    assert nothing_of_ours_is_left()


def test_keys_in_the_nla_go_too_and_those_that_another_object_plays_stay():
    ball = squashed_ball()
    ball.modifiers[0].keyframe_insert("show_render", frame=1)
    ball.keyframe_insert("location", frame=1)
    action, slot = ball.animation_data.action, ball.animation_data.action_slot
    ball.animation_data.nla_tracks.new().strips.new("Strip", 1, action)
    ball.animation_data.action = None
    twin = bpy.data.objects.new("Twin", None)
    twin.animation_data_create().action = action
    twin.animation_data.action_slot = slot
    curves = action.layers[0].strips[0].channelbag(slot).fcurves
    bpy.ops.ed.undo_push(message="shared")
    bpy.ops.isochor.apply("EXEC_DEFAULT", True)
    assert len(curves) == 4
    bpy.ops.ed.undo()
    bpy.data.objects.remove(bpy.data.objects["Twin"])
    bpy.context.view_layer.update()
    bpy.ops.isochor.apply()
    curves = bpy.data.actions[0].layers[0].strips[0].channelbags[0].fcurves
    assert {curve.data_path for curve in curves} == {"location"}


def test_invoked_from_a_menu_it_applies_at_once():
    ball = squashed_ball()
    assert bpy.ops.isochor.apply("INVOKE_DEFAULT") == {"FINISHED"}
    assert not ball.modifiers


def test_behind_a_modifier_that_only_deforms_it_is_applied_without_it_and_says_so(capfd):
    ball = squashed_ball()
    alone = scenes.evaluated_positions(ball)
    cast = ball.modifiers.new("Cast", "CAST")
    cast.factor = 0.5
    ball.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - alone).max() > 0.01
    assert bpy.ops.isochor.apply() == {"FINISHED"}
    assert np.abs(scenes.positions(ball.data) - alone).max() < 1e-6
    assert cast.show_viewport
    assert [modifier.name for modifier in ball.modifiers] == ["Cast"]
    assert "Cast comes before Volume Lattice, which was applied without it" in "".join(capfd.readouterr())


@pytest.mark.parametrize("as_shape_key", [False, True])
def test_behind_a_modifier_that_makes_vertices_it_is_refused(as_shape_key):
    ball = squashed_ball()
    ball.modifiers.new("Subdivision", "SUBSURF")
    ball.modifiers.move(1, 0)
    bpy.context.view_layer.update()
    own = scenes.positions(ball.data)
    refused("Subdivision of “Ball” makes vertices that its mesh does not have", as_shape_key=as_shape_key)
    assert np.array_equal(scenes.positions(ball.data), own)


def test_modifiers_behind_it_stay_and_the_object_looks_the_same():
    ball = squashed_ball()
    ball.modifiers.new("Subdivision", "SUBSURF")
    ball.modifiers.active = ball.modifiers[0]
    bpy.context.view_layer.update()
    shown = scenes.evaluated_positions(ball)
    bpy.ops.isochor.apply()
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    assert [modifier.name for modifier in ball.modifiers] == ["Subdivision"]


def test_a_shared_mesh_is_refused_or_copied():
    ball = squashed_ball()
    own = scenes.positions(ball.data)
    twin = bpy.data.objects.new("Twin", ball.data)
    bpy.context.scene.collection.objects.link(twin)
    shown = scenes.evaluated_positions(ball)
    refused("Other objects use the mesh of “Ball” too")
    assert bpy.ops.isochor.apply(single_user=True) == {"FINISHED"}
    assert ball.data != twin.data
    assert np.array_equal(scenes.positions(ball.data), shown)
    assert np.array_equal(scenes.positions(twin.data), own)


def test_several_objects_at_once_each_its_own_and_the_common_lattice_goes_last():
    first, second = scenes.sphere(name="One"), scenes.sphere(name="Two")
    second.location.x = 2.0
    bpy.context.view_layer.update()
    first.select_set(True)
    bpy.ops.isochor.add()
    squash(next(obj for obj in bpy.data.objects if obj.type == "LATTICE"))
    shown = [scenes.evaluated_positions(obj) for obj in (first, second)]
    assert bpy.ops.isochor.apply() == {"FINISHED"}
    for obj, shape in zip((first, second), shown, strict=True):
        assert np.array_equal(scenes.positions(obj.data), shape)
        assert not obj.modifiers
    assert nothing_of_ours_is_left()


def test_where_one_of_several_cannot_be_applied_none_is():
    first, second = squashed_ball("One"), squashed_ball("Two")
    second.shape_key_add(name="Basis")
    first.select_set(True)
    own = scenes.positions(first.data)
    refused("“Two” has shape keys")
    assert np.array_equal(scenes.positions(first.data), own)


def two_lattices() -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball with two of our modifiers in a row, and the one lattice of both."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object()
    scenes.volume_lattice(ball, lattice)
    scenes.volume_lattice(ball, lattice)
    squash(lattice, 0.7)
    return ball, lattice


@pytest.mark.parametrize("as_shape_key", [False, True])
def test_two_in_a_row_applied_together_look_the_same(as_shape_key):
    ball, lattice = two_lattices()
    shown = scenes.evaluated_positions(ball)
    scenes.choose(lattice)
    assert bpy.ops.isochor.apply(as_shape_key=as_shape_key) == {"FINISHED"}
    assert not ball.modifiers
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    assert len(ball.data.shape_keys.key_blocks) == 3 if as_shape_key else ball.data.shape_keys is None


def test_the_first_of_two_applied_leaves_the_second_working():
    ball, lattice = two_lattices()
    shown = scenes.evaluated_positions(ball)
    ball.modifiers.active = ball.modifiers[0]
    scenes.choose(ball)
    bpy.ops.isochor.apply()
    bpy.context.view_layer.update()
    assert len(ball.modifiers) == 1
    assert np.abs(scenes.evaluated_positions(ball) - shown).max() < 1e-6
    squash(lattice, 0.8)
    assert np.ptp(scenes.evaluated_positions(ball)[:, 2]) < 0.95 * np.ptp(shown[:, 2])


def test_edit_mode_hidden_and_switched_off_are_refused():
    ball = squashed_ball()
    bpy.ops.object.mode_set(mode="EDIT")
    refused("go to Object Mode first")
    bpy.ops.object.mode_set(mode="OBJECT")
    ball.modifiers[0].show_viewport = False
    refused("is switched off: switch it on")
    ball.modifiers[0].show_viewport = True
    ball.hide_viewport = True
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = ball
    with bpy.context.temp_override(object=ball):
        refused("is hidden, or in no collection")


def test_without_a_lattice_there_is_nothing_to_apply():
    ball = squashed_ball()
    bpy.data.objects.remove(bpy.data.objects["Ball Lattice"])
    refused("nothing to apply on “Ball”. No lattice")
    scenes.choose(scenes.sphere(name="Bare"))
    with pytest.raises(RuntimeError, match="Select an object with a Volume Lattice"):
        bpy.ops.isochor.apply()
    assert ball.modifiers


def test_linked_and_overridden_objects_are_refused(tmp_path):
    squashed_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    linked = wanted.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    scenes.choose(linked)
    refused("is linked from another file")
    override = linked.override_create(remap_local_usages=True)
    scenes.choose(override)
    refused("belongs to the object's library")
