# SPDX-License-Identifier: GPL-3.0-or-later
"""Several Volume Lattices on one mesh, in sequence and overlapping: the last corrects, exactly for all of them."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes

PLACES = ((0.0, 0.0, 0.0), (0.9, 0.2, 0.3), (-0.8, 0.4, -0.5), (0.1, -0.9, 0.6))
SIZES = (2.6, 1.7, 1.9, 1.6)
MODES = ("Viewport", "Render")


def overlapping(count: int) -> list[bpy.types.Object]:
    """Lattices that overlap, each shaped by a smooth push that loses or gains volume."""
    found = []
    for number, (place, size) in enumerate(zip(PLACES[:count], SIZES, strict=False)):
        lattice = scenes.lattice_object(4, name=f"Block {number}", size=size)
        lattice.location = place
        lattice.rotation_euler = (0.0, 0.0, 0.3 * number)
        found.append(lattice)
    bpy.context.view_layer.update()
    return found


def shape(lattice: bpy.types.Object, amount: float) -> None:
    """Squashes the points inside the block, so that its outer layers hold still."""
    for point in lattice.data.points:
        if max(map(abs, point.co)) < 0.4:
            point.co_deform.z += amount * (1.0 + point.co.x)
            point.co_deform.x *= 1.0 - amount
    bpy.context.view_layer.update()


def add_all(ball: bpy.types.Object, blocks: list[bpy.types.Object]) -> list[bpy.types.NodesModifier]:
    return [scenes.volume_lattice(ball, lattice) for lattice in blocks]


def error(ball: bpy.types.Object, factor: float = 1.0) -> float:
    """Of the volume that Blender shows, against the mesh's own."""
    return abs(scenes.evaluated_volume(ball) / (factor * scenes.volume(ball.data)) - 1.0)


def preserve_of(modifiers: list[bpy.types.NodesModifier]) -> list[float]:
    return [scenes.get_input(modifier, "Preserve") for modifier in modifiers]


@pytest.mark.parametrize("count", [2, 4])
def test_blocks_in_a_row_are_corrected_by_the_last_alone(count):
    ball = scenes.sphere()
    blocks = overlapping(count)
    modifiers = add_all(ball, blocks)
    assert preserve_of(modifiers) == [0.0] * (count - 1) + [1.0]
    for number, lattice in enumerate(blocks):
        shape(lattice, 0.2 + 0.05 * number)
    assert error(ball) <= 1e-6
    assert scenes.report(ball, modifiers[-1]).problems == ()
    scenes.set_input(modifiers[-1], "Preserve", 0.0)
    bpy.context.view_layer.update()
    assert error(ball) > 1e-3
    scenes.set_input(modifiers[-1], "Preserve", 0.5)
    bpy.context.view_layer.update()
    assert error(ball) > 1e-4


@pytest.mark.parametrize("count", [2, 4])
def test_blocks_added_to_what_others_have_shaped_already_keep_what_entered_the_first(count):
    ball = scenes.sphere()
    blocks = overlapping(count)
    modifiers = []
    for number, lattice in enumerate(blocks):
        modifiers.append(scenes.volume_lattice(ball, lattice))
        assert error(ball) <= 1e-6
        scenes.set_input(modifiers[-1], "Preserve", 0.0)
        shape(lattice, 0.3 + 0.05 * number)
        assert error(ball) > 1e-3
        scenes.set_input(modifiers[-1], "Preserve", 1.0)
        bpy.context.view_layer.update()
        assert error(ball) <= 1e-6
    kept = {scenes.get_input(found, f"{mode} Result")["isochor_rest_volume"] for found in modifiers for mode in MODES}
    assert len(kept) == 1


def test_blocks_before_the_last_that_never_corrected_count_too():
    ball = scenes.sphere()
    one, two = overlapping(2)
    first = scenes.volume_lattice(ball, one, Preserve=0.0)
    shape(one, 0.4)
    lost = error(ball)
    last = scenes.volume_lattice(ball, two)
    assert preserve_of([first, last]) == [0.0, 1.0]
    assert lost > 1e-2
    assert error(ball) <= 1e-6


def test_islands_of_a_chain_keep_what_entered_the_first():
    ball = scenes.sphere()
    twin = scenes.sphere(16, 10, "Twin")
    twin.location = (2.4, 0.0, 0.0)
    ball.select_set(True)
    bpy.context.view_layer.objects.active = ball
    bpy.context.view_layer.update()
    bpy.ops.object.join()
    wanted = scenes.part("core.bodies").volumes(*own(ball), scenes.part("core.bodies").Bodies(True, False))
    one, two = scenes.lattice_object(4, "One", 5.5), scenes.lattice_object(4, "Two", 5.7)
    first = scenes.volume_lattice(ball, one, Islands=True, Preserve=0.0)
    shape(one, 0.3)
    last = scenes.volume_lattice(ball, two, Islands=True)
    for reference in ("Rest", "Incoming"):
        scenes.set_input(last, "Reference", reference)
        shape(two, 0.1)
        found = scenes.part("core.bodies").volumes(
            scenes.evaluated_positions(ball), own(ball)[1], scenes.part("core.bodies").Bodies(True, False)
        )
        assert len(wanted) == 2
        assert np.abs(found / wanted - 1.0).max() <= 1e-6
    assert preserve_of([first]) == [0.0]


def own(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    return scenes.part("tool.evaluated").own_shape(obj.data)


def test_incoming_is_what_enters_the_first_that_does_not_correct():
    ball = scenes.sphere()
    one, two = overlapping(2)
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Inflated")
    for point in key.data:
        point.co *= 1.2
    key.value = 0.0
    first = scenes.volume_lattice(ball, one)
    scenes.volume_lattice(ball, two, Reference="Incoming")
    shape(one, 0.3)
    shape(two, 0.3)
    for value in (0.0, 1.0, 0.5):
        key.value = value
        bpy.context.view_layer.update()
        assert error(ball, (1.0 + 0.2 * value) ** 3) <= 2e-6
    scenes.set_input(first, "Preserve", 1.0)
    scenes.set_input(first, "Target", 1.1)
    bpy.context.view_layer.update()
    assert error(ball, 1.1) <= 2e-6


def test_rest_of_the_whole_chain_is_measured_again_with_one_of_it():
    ball = scenes.sphere()
    one, two = overlapping(2)
    modifiers = add_all(ball, [one, two])
    shape(one, 0.3)
    for vertex in ball.data.vertices:
        vertex.co *= 1.1
    ball.data.update()
    bpy.context.view_layer.update()
    assert any("edited" in text for text in scenes.report(ball, modifiers[1]).problems)
    for lattice, operator in ((one, bpy.ops.isochor.fit_lattice), (two, bpy.ops.isochor.set_rest)):
        scenes.choose(lattice)
        assert operator() == {"FINISHED"}
        assert error(ball) <= 1e-6
        for modifier in modifiers:
            assert scenes.report(ball, modifier).problems == ()
        for vertex in ball.data.vertices:
            vertex.co *= 1.05
        ball.data.update()
        bpy.context.view_layer.update()


def test_order_of_blocks_is_that_of_the_stack():
    ball = scenes.sphere()
    blocks = overlapping(2)
    add_all(ball, blocks)
    for modifier in ball.modifiers:
        scenes.set_input(modifier, "Preserve", 0.0)
    shape(blocks[0], 0.3)
    shape(blocks[1], 0.35)
    seen = []
    for order in (blocks, blocks[::-1]):
        wanted = scenes.positions(ball.data)
        for lattice in order:
            wanted = lattice_oracle.deformed(ball, lattice, wanted, "Bernstein")
        found = scenes.evaluated_positions(ball)
        # A vertex on a face may be inside for one precision and outside for the other; there is none here.
        assert np.abs(found - wanted).max() < 3e-6
        seen.append(found)
        ball.modifiers.move(1, 0)
        bpy.context.view_layer.update()
    assert np.abs(seen[0] - seen[1]).max() > 1e-3


def test_added_again_the_lattice_is_fitted_to_the_shape_that_the_first_left():
    ball = scenes.sphere()
    one = scenes.lattice_object(4, "One", 2.6)
    scenes.volume_lattice(ball, one, Preserve=0.0)
    for point in one.data.points:
        point.co_deform.x *= 2.0
        point.co_deform.x += 0.3
    bpy.context.view_layer.update()
    shown = scenes.evaluated_positions(ball)
    scenes.choose(ball)
    assert bpy.ops.isochor.add(margin=0.0) == {"FINISHED"}
    added = scenes.get_input(ball.modifiers[-1], "Lattice")
    assert list(added.location) == pytest.approx((shown.max(0) + shown.min(0)) / 2.0, abs=1e-5)
    assert list(added.scale) == pytest.approx(np.ptp(shown, axis=0), abs=1e-4)
    assert scenes.report(ball, ball.modifiers[-1]).vertices_outside == 0


def test_settings_of_the_volume_go_to_the_one_added_and_come_back_when_it_goes():
    ball = scenes.sphere()
    first = scenes.volume_lattice(ball, scenes.lattice_object(4, "One"), Axes=(1.0, 1.0, 0.0), Method="Nearest")
    scenes.set_input(first, "Target", 1.2)
    scenes.choose(ball)
    bpy.ops.ed.undo_push(message="Before")
    assert bpy.ops.isochor.add() == {"FINISHED"}
    last = ball.modifiers[-1]
    assert preserve_of([first, last]) == [0.0, 1.0]
    assert tuple(scenes.get_input(last, "Axes")) == (1.0, 1.0, 0.0)
    assert scenes.get_input(last, "Method") == "Nearest"
    assert error(ball, 1.2) <= 1e-6
    scenes.set_input(last, "Preserve", 0.75)
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert preserve_of([first]) == [0.75]


def test_each_corrects_where_that_is_asked_for_or_keyed():
    ball = scenes.sphere()
    first = scenes.volume_lattice(ball, scenes.lattice_object(4, "One"))
    scenes.choose(ball)
    assert bpy.ops.isochor.add(only_last=False) == {"FINISHED"}
    assert preserve_of([first, ball.modifiers[-1]]) == [1.0, 1.0]
    bpy.ops.isochor.remove()
    path = scenes.part("tool.drivers").data_path(first, "Preserve")
    ball.keyframe_insert(path, frame=1)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    assert preserve_of([first, ball.modifiers[-1]]) == [1.0, 1.0]


def test_sidebar_says_where_more_or_less_than_the_last_corrects():
    ball = scenes.sphere()
    first, last = add_all(ball, [scenes.lattice_object(4, "One"), scenes.lattice_object(4, "Two")])
    notes = scenes.part("ui.sidebar").notes_on_chain
    assert notes(ball, first) == notes(ball, last) == []
    scenes.set_input(first, "Preserve", 1.0)
    assert "further down corrects" in notes(ball, first)[0]
    assert notes(ball, last) == []
    scenes.set_input(last, "Preserve", 0.0)
    assert notes(ball, first) == []
    assert "does not correct" in notes(ball, last)[0]


def test_adding_and_handing_over_is_one_step_of_undo():
    ball = scenes.sphere()
    scenes.volume_lattice(ball, scenes.lattice_object(4, "One"))
    scenes.choose(ball)
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.isochor.add()
    bpy.ops.ed.undo_push(message="Added")
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert preserve_of(list(ball.modifiers)) == [1.0]
