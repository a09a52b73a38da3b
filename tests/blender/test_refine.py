# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.refine: more points, the same shape over an animation, with shape keys, groups, drivers and keys."""

import bpy
import native_scenes
import numpy as np
import pytest
import scenes

FRAMES = 6
CLOSE = 1e-6


def scene(basis: str, shape: tuple[int, int, int], size: float = 3.4, **inputs):
    """A ball in a lattice with every point moved, which slides through it."""
    ball = scenes.sphere()
    lattice = native_scenes.shaken(shape, ("KEY_LINEAR",) * 3, size)
    if basis == "B-Spline":
        for axis, points in enumerate(shape):
            lattice.scale[axis] = 2.6 * max(points - 1, 1) / max(points - max(1, min(3, points - 1)), 1)
    modifier = scenes.volume_lattice(ball, lattice, Basis=basis, Preserve=0.0, Outside="Extend", **inputs)
    return ball, lattice, modifier


def shape_of(lattice: bpy.types.Object) -> tuple[int, int, int]:
    return lattice.data.points_u, lattice.data.points_v, lattice.data.points_w


def shapes(ball: bpy.types.Object) -> np.ndarray:
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(ball))
    return np.array(found)


def refined(ball: bpy.types.Object, **properties) -> None:
    scenes.choose(ball)
    assert bpy.ops.isochor.refine(**properties) == {"FINISHED"}


def refused(obj: bpy.types.Object, **properties) -> str:
    scenes.choose(obj)
    before = {one.name: shape_of(one) for one in bpy.data.objects if one.type == "LATTICE"}
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.isochor.refine(**properties)
    assert before == {one.name: shape_of(one) for one in bpy.data.objects if one.type == "LATTICE"}
    return str(caught.value)


def keyed(lattice: bpy.types.Object, relative: bool = True) -> bpy.types.Key:
    """Two shape keys, one on the other, keyed and driven, with all their settings."""
    lattice.shape_key_add(name="Basis")
    for number in range(2):
        key, random = lattice.shape_key_add(name=f"Key {number}", from_mix=False), np.random.default_rng(number)
        for point in key.data:
            point.co = [place + random.normal(0.0, 0.1) for place in point.co]
    keys = lattice.data.shape_keys
    keys.use_relative = relative
    one, two = keys.key_blocks[1:]
    one.slider_min, one.slider_max, one.value = -2.0, 3.0, 0.4
    two.relative_key, two.interpolation = one, "KEY_BSPLINE"
    for frame in (1, FRAMES):
        keys.eval_time = 20.0 * (frame - 1) / FRAMES
        keys.keyframe_insert("eval_time", frame=frame)
        one.value = 1.4 / frame
        one.keyframe_insert("value", frame=frame)
    two.driver_add("value").driver.expression = "frame / 8"
    lattice.active_shape_key_index = 1
    return keys


CASES = [
    ("Bernstein", (4, 3, 2), (0, 0, 0), (5, 4, 3)),
    ("Bernstein", (3, 4, 2), (6, 4, 3), (6, 4, 3)),
    ("Bernstein", (3, 1, 4), (0, 3, 0), (4, 3, 5)),
    ("B-Spline", (5, 4, 6), (0, 0, 0), (7, 5, 9)),
    ("B-Spline", (5, 6, 4), (9, 6, 7), (9, 6, 7)),
    ("B-Spline", (3, 2, 5), (0, 0, 0), (5, 5, 7)),
    ("B-Spline", (1, 5, 4), (0, 0, 0), (1, 7, 5)),
]


@pytest.mark.parametrize(("basis", "shape", "asked", "wanted"), CASES)
@pytest.mark.parametrize("turned", [False, True], ids=["straight", "turned"])
def test_the_shape_stays_and_the_volume_is_then_kept_too(basis, shape, asked, wanted, turned):
    ball, lattice, modifier = scene(basis, shape)
    if turned:
        lattice.rotation_euler, lattice.location = (0.2, -0.3, 0.5), (0.1, 0.0, -0.1)
        native_scenes.sheared(ball, 0.2)
    bpy.context.view_layer.update()
    before = scenes.evaluated_positions(ball)
    refined(ball, resolution=asked)
    assert shape_of(lattice) == wanted
    assert native_scenes.apart(scenes.evaluated_positions(ball), before) <= 2 * CLOSE
    assert native_scenes.apart(before, scenes.positions(ball.data)) > 0.02
    assert scenes.report(ball, modifier).problems == ()
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6


@pytest.mark.parametrize("relative", [True, False], ids=["relative", "absolute"])
@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_shape_keys_keep_all_that_is_set_and_animated(basis, relative):
    ball, lattice, _modifier = scene(basis, (4, 5, 4))
    keys = keyed(lattice, relative)
    reader = scenes.lattice_object(2, name="Reader")
    driver = reader.driver_add("location", 0).driver
    variable = driver.variables.new()
    variable.name = "value"
    target = variable.targets[0]
    target.id_type, target.id, target.data_path = "KEY", keys, 'key_blocks["Key 0"].value'
    driver.expression = "value"
    before = shapes(ball)
    frames = [block.frame for block in keys.key_blocks]
    lattices = len(bpy.data.lattices)
    refined(lattice)
    keys = lattice.data.shape_keys
    assert native_scenes.apart(shapes(ball), before) <= 2 * CLOSE
    assert native_scenes.apart(before[0], before[-1]) > 0.005
    assert keys.key_blocks.keys() == ["Basis", "Key 0", "Key 1"]
    assert [block.frame for block in keys.key_blocks] == frames
    one, two = keys.key_blocks[1:]
    assert (one.slider_min, one.slider_max, two.relative_key, two.interpolation) == (-2.0, 3.0, one, "KEY_BSPLINE")
    assert (keys.use_relative, lattice.active_shape_key_index) == (relative, 1)
    bpy.context.scene.frame_set(3)
    shown = reader.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert shown.location.x == pytest.approx(one.value, abs=1e-6)
    assert one.value > 0.3
    assert two.value == pytest.approx(3 / 8)
    assert len(bpy.data.lattices) == lattices


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_weights_of_the_points_are_refined_with_it_and_other_groups_carried(basis):
    ball, lattice, modifier = scene(basis, (4, 5, 4), Weights="Heavy", Heaviest=6.0)
    native_scenes.group(lattice, "Heavy")
    group = lattice.vertex_groups.new(name="Stiff")
    group.add([number for number, point in enumerate(lattice.data.points) if point.co.z > 0.0], 1.0, "REPLACE")
    lattice.update_tag(refresh={"DATA"})
    lattice.data.update_tag()
    keyed(lattice)
    before = shapes(ball)
    assert scenes.report(ball, modifier).problems == ()
    scenes.set_input(modifier, "Weights", "")
    assert native_scenes.apart(shapes(ball), before) > 0.005
    scenes.set_input(modifier, "Weights", "Heavy")
    refined(ball)
    assert native_scenes.apart(shapes(ball), before) <= 3 * CLOSE
    stiff = scenes.part("tool.lattice_weights").of_group(lattice, "Stiff")
    assert stiff[:, :, -1].min() == 1.0
    assert stiff[:, :, 0].max() == 0.0


def test_a_linear_lattice_of_blenders_basis_gets_the_points_between():
    ball, lattice, _modifier = scene("Blender", (3, 2, 1))
    keyed(lattice)
    before = shapes(ball)
    refined(ball)
    assert shape_of(lattice) == (5, 3, 1)
    assert native_scenes.apart(shapes(ball), before) <= CLOSE
    lattice.data.interpolation_type_u = "KEY_BSPLINE"
    assert "U of “Cage” is smooth" in refused(ball)


def test_an_animated_scale_and_children_stay():
    ball, lattice, _modifier = scene("B-Spline", (5, 5, 5))
    child = bpy.data.objects.new("Child", None)
    bpy.context.scene.collection.objects.link(child)
    child.parent, child.location = lattice, (0.3, 0.2, 0.1)
    sizes = np.array(lattice.scale)
    for frame, factor in ((1, 1.0), (FRAMES, 1.2)):
        lattice.scale = sizes * factor
        lattice.keyframe_insert("scale", frame=frame)
    before = shapes(ball)
    place = np.array(child.matrix_world)
    refined(ball)
    assert native_scenes.apart(shapes(ball), before) <= 2 * CLOSE
    assert np.allclose(np.array(child.matrix_world), place, atol=1e-6)
    assert native_scenes.apart(before[0], before[-1]) > 0.005
    lattice.delta_scale.x *= 1.0
    lattice.keyframe_insert("delta_scale", frame=1)
    assert "animated twice" in refused(ball)


def test_two_meshes_two_objects_with_the_same_points_and_one_undo():
    ball, lattice, modifier = scene("B-Spline", (5, 5, 5))
    other = lattice.copy()
    bpy.context.scene.collection.objects.link(other)
    other.location.x = 0.2
    second = scenes.sphere(name="Second")
    scenes.volume_lattice(second, other, Basis="B-Spline", Preserve=0.0)
    scenes.set_input(modifier, "Outside", "Keep")
    bpy.context.view_layer.update()
    before = [scenes.evaluated_positions(obj) for obj in (ball, second)]
    scenes.choose(ball)
    second.select_set(True)
    bpy.ops.ed.undo_push()
    assert bpy.ops.isochor.refine() == {"FINISHED"}
    bpy.ops.ed.undo_push()
    assert shape_of(lattice) == (7, 7, 7)
    for obj, shape in zip((ball, second), before, strict=True):
        assert native_scenes.apart(scenes.evaluated_positions(obj), shape) <= 2 * CLOSE
    bpy.ops.ed.undo()
    assert shape_of(bpy.data.objects["Cage"]) == (5, 5, 5)


def test_refusals_in_plain_words():
    ball, lattice, modifier = scene("Bernstein", (4, 4, 4))
    assert "3 would deform otherwise" in refused(ball, resolution=(3, 0, 0))
    assert "So many points there are already" in refused(ball, resolution=(4, 4, 4))
    hook = lattice.modifiers.new("Hook", "HOOK")
    assert "such as hooks" in refused(ball)
    lattice.modifiers.remove(hook)
    lattice.data.points[3].keyframe_insert("co_deform", frame=1)
    assert "animated one by one" in refused(ball)
    lattice.data.animation_data_clear()
    second = scenes.sphere(name="Second")
    native = scenes.native_lattice(second, lattice)
    assert "convert that first" in refused(ball)
    second.modifiers.remove(native)
    scenes.volume_lattice(second, lattice, Basis="B-Spline")
    assert "by different Basis or Weights" in refused(ball)
    bpy.data.objects.remove(second)
    scenes.choose(ball)
    bpy.ops.isochor.set_rest()
    assert "the rest with “Cage” was set" in refused(ball)
    bpy.ops.isochor.clear_rest()
    key = lattice.shape_key_add(name="Basis")
    lattice.vertex_groups.new(name="Some")
    key.vertex_group = "Some"
    assert "act through a vertex group" in refused(ball)
    key.vertex_group = ""
    lattice.data.use_outside = True
    assert "has Outside on" in refused(ball)
    lattice.data.use_outside = False
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    assert "is in Edit Mode" in refused_in_edit_mode()
    bpy.ops.object.mode_set(mode="OBJECT")
    scenes.set_input(modifier, "Twist", 0.4)
    refined(ball)
    lattice.data = bpy.data.lattices.new("Alone")
    scenes.set_input(modifier, "Lattice", None)
    assert "shapes nothing" in refused(lattice)


def refused_in_edit_mode() -> str:
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.isochor.refine()
    return str(caught.value)


def test_fit_again_takes_shape_keys_and_splines_along():
    ball, lattice, _modifier = scene("B-Spline", (4, 5, 4))
    keyed(lattice)
    scenes.choose(ball)
    assert bpy.ops.isochor.fit_lattice(margin=0.2) == {"FINISHED"}
    before = shapes(ball)
    scenes.choose(ball)
    assert bpy.ops.isochor.fit_lattice(resolution=(5, 7, 6), margin=0.2) == {"FINISHED"}
    assert shape_of(lattice) == (5, 7, 6)
    assert native_scenes.apart(shapes(ball), before) <= 3 * CLOSE
