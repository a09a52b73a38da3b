# SPDX-License-Identifier: GPL-3.0-or-later
"""The basis Blender: the same as Blender's own Lattice modifier, to 1e-6 of the object's size."""

from itertools import product

import bpy
import elsewhere
import native_scenes
import numpy as np
import pytest
import scenes
from native_scenes import CLOSE, TYPES

MIXED = [("KEY_LINEAR", "KEY_CARDINAL", "KEY_BSPLINE"), ("KEY_CATMULL_ROM", "KEY_LINEAR", "KEY_CARDINAL")]
BSPLINE = ("KEY_BSPLINE",) * 3
SHAPES = [(2, 2, 2), (3, 4, 5), (1, 3, 4), (5, 1, 1), (7, 2, 6)]


@pytest.mark.parametrize(("types", "shape"), product([*((one,) * 3 for one in TYPES), *MIXED], SHAPES))
@pytest.mark.parametrize("size", [2.6, 1.1], ids=["inside", "outside"])
def test_every_type_and_resolution(types, shape, size):
    lattice = native_scenes.shaken(shape, types, size)
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    native_scenes.require_same(ball, twin)
    assert scenes.report(ball, ball.modifiers[0]).problems == ()


@pytest.mark.parametrize("types", [BSPLINE, MIXED[1]])
def test_transforms_of_both_and_sheared_parents(types):
    lattice = native_scenes.shaken((4, 3, 5), types, 2.2)
    lattice.location, lattice.rotation_euler, lattice.scale = (0.2, -0.1, 0.3), (0.4, 0.2, 0.7), (2.6, 1.9, 2.2)
    native_scenes.sheared(lattice, 0.5)
    ball, twin = native_scenes.pair(lattice)
    native_scenes.sheared(ball, -0.3)
    ball.scale, ball.location = (1.5, 0.8, 1.1), (0.1, 0.2, 0.0)
    bpy.context.view_layer.update()
    twin.matrix_world = ball.matrix_world
    twin.parent, twin.matrix_parent_inverse = ball.parent, ball.matrix_parent_inverse
    twin.matrix_basis = ball.matrix_basis
    native_scenes.native(twin, lattice)
    native_scenes.require_same(ball, twin)


@pytest.mark.parametrize("invert", [False, True])
@pytest.mark.parametrize("own", [False, True], ids=["", "lattice's own group"])
def test_strength_and_vertex_groups(invert, own):
    lattice = native_scenes.shaken((4, 3, 5), BSPLINE)
    if own:
        native_scenes.group(lattice, "Own")
        lattice.data.vertex_group = "Own"
    ball, twin = native_scenes.pair(lattice, Strength=0.7, Vertex_Group="Part", Invert=invert)
    native_scenes.group(ball)
    twin.vertex_groups.new(name="Part")
    native_scenes.native(twin, lattice, strength=0.7, vertex_group="Part", invert_vertex_group=invert)
    native_scenes.require_same(ball, twin)


@pytest.mark.parametrize("types", [BSPLINE, ("KEY_LINEAR",) * 3, ("KEY_LINEAR", "KEY_BSPLINE", "KEY_LINEAR")])
def test_the_lattices_own_vertex_group_follows_edits(types):
    lattice = native_scenes.shaken((5, 4, 4), types, 1.6)
    native_scenes.group(lattice, "Own")
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    native_scenes.require_same(ball, twin)
    free = scenes.evaluated_positions(ball)
    lattice.data.vertex_group = "Own"
    lattice.data.update_tag()
    native_scenes.require_same(ball, twin)
    assert native_scenes.apart(free, scenes.evaluated_positions(ball)) > 0.01
    lattice.vertex_groups["Own"].add(range(40), 1.0, "REPLACE")
    lattice.data.update_tag()
    native_scenes.require_same(ball, twin)


def test_use_outside():
    lattice = native_scenes.shaken((5, 5, 6), MIXED[0])
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    native_scenes.require_same(ball, twin)
    before = scenes.evaluated_positions(ball)
    lattice.data.use_outside = True
    lattice.data.update_tag()
    native_scenes.require_same(ball, twin)
    assert native_scenes.apart(before, scenes.evaluated_positions(ball)) > 0.01


@pytest.mark.parametrize("relative", [True, False], ids=["relative", "absolute"])
@pytest.mark.parametrize("use_outside", [False, True])
def test_shape_keys_of_the_lattice_over_an_animation(relative, use_outside):
    lattice = native_scenes.shaken((4, 4, 4), BSPLINE)
    lattice.shape_key_add(name="Basis")
    for number in range(2):
        key, random = lattice.shape_key_add(name=f"Key {number}", from_mix=False), np.random.default_rng(number)
        for point in key.data:
            point.co = [place + random.normal(0.0, 0.1) for place in point.co]
    keys = lattice.data.shape_keys
    keys.use_relative = relative
    lattice.data.use_outside = use_outside
    for frame in (1, native_scenes.FRAMES):
        keys.eval_time = 20.0 * (frame - 1) / native_scenes.FRAMES
        keys.keyframe_insert("eval_time", frame=frame)
        keys.key_blocks[1].value = 1.0 / frame
        keys.key_blocks[1].keyframe_insert("value", frame=frame)
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    shown = []
    for frame in range(1, native_scenes.FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        native_scenes.require_same(ball, twin)
        shown.append(scenes.evaluated_positions(ball))
    assert native_scenes.apart(shown[0], shown[-1]) > 0.01


def test_a_change_of_the_interpolation_type_is_followed_also_by_a_bound_rest():
    lattice = native_scenes.shaken((4, 5, 4), BSPLINE)
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    native_scenes.require_same(ball, twin)
    native_scenes.set_types(lattice, MIXED[0])
    lattice.data.update_tag()
    native_scenes.require_same(ball, twin)
    scenes.choose(ball)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    assert native_scenes.apart(scenes.evaluated_positions(ball), scenes.positions(ball.data)) < CLOSE
    for types in (BSPLINE, MIXED[1]):
        native_scenes.set_types(lattice, types)
        lattice.data.update_tag()
        bpy.context.view_layer.update()
        assert scenes.report(ball, ball.modifiers[0]).bound.grid.interpolation == types


@pytest.mark.parametrize("types", [BSPLINE, *MIXED])
@pytest.mark.parametrize("outside", ["Keep", "Extend"])
def test_the_volume_is_kept_with_every_type(types, outside):
    lattice = native_scenes.shaken((5, 4, 6), types, 2.6 if outside == "Keep" else 1.4)
    ball, _twin = native_scenes.pair(lattice)
    scenes.set_input(ball.modifiers[0], "Outside", outside)
    scenes.set_input(ball.modifiers[0], "Preserve", 1.0)
    bpy.context.view_layer.update()
    assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    assert scenes.report(ball, ball.modifiers[0]).problems == ()


def test_keep_leaves_what_is_outside_the_grid():
    lattice = native_scenes.shaken((4, 4, 4), BSPLINE, 1.4)
    ball, twin = native_scenes.pair(lattice)
    native_scenes.native(twin, lattice)
    scenes.set_input(ball.modifiers[0], "Outside", "Keep")
    bpy.context.view_layer.update()
    own, shown = scenes.positions(ball.data), scenes.evaluated_positions(ball)
    outside = np.abs(own).max(axis=1) > 0.7001
    assert 0 < outside.sum() < len(own)
    assert np.array_equal(shown[outside], own[outside])
    inside = np.abs(own).max(axis=1) < 0.6999
    assert native_scenes.apart(shown[inside], scenes.evaluated_positions(twin)[inside]) <= CLOSE


@pytest.mark.parametrize("own", [False, True], ids=["", "lattice's own group"])
def test_a_lattice_bake_has_the_very_same_points(tmp_path, own):
    lattice = native_scenes.shaken((4, 3, 5), MIXED[0], 2.8)
    if own:
        native_scenes.set_types(lattice, BSPLINE)
        native_scenes.group(lattice, "Own")
        lattice.data.vertex_group = "Own"
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
    ball, _twin = native_scenes.pair(lattice)
    scenes.set_input(ball.modifiers[0], "Preserve", 1.0)
    ball.location.x = 0.3
    for frame, height in ((1, 2.8), (3, 1.4)):
        lattice.scale.z = height
        lattice.keyframe_insert("scale", frame=frame)
    shown = []
    for frame in (1, 2, 3):
        bpy.context.scene.frame_set(frame)
        shown.append(scenes.evaluated_positions(ball))
    scenes.choose(ball)
    assert bpy.ops.isochor.bake(format="LATTICE") == {"FINISHED"}
    played = elsewhere.played(tmp_path, ball.name, [1.0, 2.0, 3.0])
    for one, other in zip(played, shown, strict=True):
        assert native_scenes.apart(one, other) <= 2 * CLOSE
        assert abs(elsewhere.volume(one, ball) / scenes.volume(ball.data) - 1) <= 2e-6
    assert native_scenes.apart(shown[0], shown[-1]) > 0.001


def test_added_with_the_basis_it_is_like_a_new_lattice_modifier():
    ball = scenes.sphere()
    assert bpy.ops.isochor.add(resolution=(3, 4, 3), basis="BLENDER") == {"FINISHED"}
    lattice = scenes.get_input(ball.modifiers[0], "Lattice")
    twin = bpy.data.objects.new("Twin", ball.data)
    bpy.context.scene.collection.objects.link(twin)
    native_scenes.native(twin, lattice)
    scenes.set_input(ball.modifiers[0], "Preserve", 0.0)
    lattice.data.points[5].co_deform.x += 0.3
    native_scenes.require_same(ball, twin)
