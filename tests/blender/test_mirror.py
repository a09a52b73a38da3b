# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.mirror_lattice: one side the mirror image of the other, in every way that lattices are edited."""

import bpy
import numpy as np
import pytest
import scenes

SHAPES = ((4, 4, 4), (3, 5, 2), (6, 3, 5))


def points(holder, name: str = "co_deform") -> np.ndarray:
    found = np.empty(len(holder) * 3, np.float32)
    holder.foreach_get(name, found)
    return found.reshape(-1, 3)


def grid(lattice: bpy.types.Object, found: np.ndarray | None = None) -> np.ndarray:
    """Points by [w, v, u]."""
    data = lattice.data
    found = points(data.points) if found is None else found
    return found.reshape(data.points_w, data.points_v, data.points_u, 3)


def shaken(shape: tuple[int, int, int] = (4, 4, 4), name: str = "Lattice") -> bpy.types.Object:
    lattice = scenes.lattice_object(shape, name=name)
    found = points(lattice.data.points) + np.random.default_rng(3).normal(0.0, 0.1, (len(lattice.data.points), 3))
    lattice.data.points.foreach_set("co_deform", found.astype(np.float32).reshape(-1))
    scenes.choose(lattice)
    bpy.context.view_layer.update()
    return lattice


def image(cells: np.ndarray, axis: int) -> np.ndarray:
    """Every point where the mirror sends its partner."""
    flipped = np.flip(cells, 2 - axis).copy()
    flipped[..., axis] *= -1.0
    return flipped


def side(cells: np.ndarray, axis: int, positive: bool) -> np.ndarray:
    """The layers of one side; a middle layer belongs to none."""
    count = cells.shape[2 - axis]
    layers = range((count + 1) // 2, count) if positive else range(count // 2)
    return np.take(cells, list(layers), axis=2 - axis)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("direction", ["POSITIVE_TO_NEGATIVE", "NEGATIVE_TO_POSITIVE"])
@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_the_lattice_becomes_symmetric_and_the_model_side_stays(shape, direction, axis):
    lattice = shaken(shape)
    before, number = grid(lattice), "XYZ".index(axis)
    assert bpy.ops.isochor.mirror_lattice(axis=axis, direction=direction) == {"FINISHED"}
    after = grid(lattice)
    assert np.array_equal(after, image(after, number))
    model = direction == "POSITIVE_TO_NEGATIVE"
    assert np.array_equal(side(after, number, model), side(before, number, model))
    assert not np.array_equal(side(after, number, not model), side(before, number, not model))
    others = [coordinate for coordinate in range(3) if coordinate != number]
    middle = np.take(after, [shape[number] // 2], axis=2 - number)
    if shape[number] % 2:
        assert np.all(middle[..., number] == 0.0)
        assert np.array_equal(middle[..., others], np.take(before, [shape[number] // 2], axis=2 - number)[..., others])
    assert bpy.ops.isochor.mirror_lattice(axis=axis, direction=direction) == {"FINISHED"}
    assert np.array_equal(grid(lattice), after)


def test_a_symmetric_mesh_comes_out_symmetric_with_its_volume():
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    diamond = scenes.mesh_object("Diamond", corners, faces)
    lattice = shaken()
    scenes.volume_lattice(diamond, lattice)
    scenes.choose(diamond)
    assert bpy.ops.isochor.mirror_lattice(axis="X") == {"FINISHED"}
    bpy.context.view_layer.update()
    found, flat = scenes.evaluated_positions(diamond), scenes.positions(diamond.data)
    partner = [int(np.argmin(np.abs(flat - place * (-1, 1, 1)).sum(axis=1))) for place in flat]
    assert np.abs(found - flat).max() > 0.02
    assert np.abs(found[partner] * (-1, 1, 1) - found).max() < 1e-6
    assert abs(scenes.evaluated_volume(diamond) / scenes.volume(diamond.data) - 1) <= 1e-6


@pytest.mark.parametrize("active", [0, 1])
def test_only_the_active_shape_key_changes(active):
    lattice = shaken()
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Bent", from_mix=False)
    key.value = 1.0
    lattice.active_shape_key_index = active
    blocks = lattice.data.shape_keys.key_blocks
    key.data[0].co.x -= 0.4
    before = [points(block.data, "co") for block in blocks]
    assert bpy.ops.isochor.mirror_lattice(axis="X", direction="NEGATIVE_TO_POSITIVE") == {"FINISHED"}
    after = [points(block.data, "co") for block in blocks]
    assert np.array_equal(after[1 - active], before[1 - active])
    changed = grid(lattice, after[active])
    assert np.array_equal(changed, image(changed, 0))
    assert not np.array_equal(after[active], before[active])
    if active == 1:
        bpy.context.view_layer.update()
        shown = lattice.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.points[3].co_deform
        assert np.allclose(shown, after[1][3])


def test_only_pairs_with_a_selected_point_in_edit_mode():
    lattice = shaken()
    ball = scenes.sphere()
    scenes.volume_lattice(ball, lattice)
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="DESELECT")
    before, shape = points(lattice.data.points), scenes.evaluated_positions(ball)
    lattice.data.points[0].select = True  # on the negative side: the model, or the one that changes
    lattice.data.points[6].select = True  # on the positive side
    assert bpy.ops.isochor.mirror_lattice(axis="X", direction="POSITIVE_TO_NEGATIVE") == {"FINISHED"}
    after = points(lattice.data.points)
    assert sorted(np.flatnonzero(np.any(after != before, axis=1))) == [0, 5]
    assert np.array_equal(after[0], before[3] * (-1, 1, 1))
    assert np.array_equal(after[5], before[6] * (-1, 1, 1))
    bpy.context.view_layer.update()
    assert np.abs(scenes.evaluated_positions(ball) - shape).max() > 1e-3
    assert bpy.ops.isochor.mirror_lattice(axis="X", only_selected=False) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    whole = grid(lattice)
    assert np.array_equal(whole, image(whole, 0))


def test_edit_mode_works_on_the_shape_key_that_is_edited():
    lattice = shaken()
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Bent", from_mix=False)
    lattice.active_shape_key_index = 1
    basis = points(lattice.data.shape_keys.key_blocks[0].data, "co")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="SELECT")
    assert bpy.ops.isochor.mirror_lattice(axis="Z") == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    found = grid(lattice, points(key.data, "co"))
    assert np.array_equal(found, image(found, 2))
    assert np.array_equal(points(lattice.data.shape_keys.key_blocks[0].data, "co"), basis)


def test_every_selected_lattice_once_even_where_two_share_their_points():
    one, other = shaken(name="One"), shaken((3, 3, 3), name="Other")
    twin = bpy.data.objects.new("Twin", one.data)
    bpy.context.scene.collection.objects.link(twin)
    for obj in (one, other, twin):
        obj.select_set(True)
    assert bpy.ops.isochor.mirror_lattice(axis="Y") == {"FINISHED"}
    for lattice in (one, other):
        assert np.array_equal(grid(lattice), image(grid(lattice), 1))


def test_one_undo_step_in_object_mode_and_in_edit_mode():
    lattice = shaken()
    before = points(lattice.data.points)
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.mirror_lattice("EXEC_DEFAULT", True, axis="X")
    assert not np.array_equal(points(lattice.data.points), before)
    bpy.ops.ed.undo()
    assert np.array_equal(points(bpy.data.objects["Lattice"].data.points), before)
    bpy.ops.ed.redo()
    lattice = bpy.data.objects["Lattice"]
    assert np.array_equal(grid(lattice), image(grid(lattice), 0))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="SELECT")
    before = points(lattice.data.points)
    bpy.ops.ed.undo_push(message="editing")
    bpy.ops.isochor.mirror_lattice("EXEC_DEFAULT", True, axis="Z")
    assert not np.array_equal(points(lattice.data.points), before)
    bpy.ops.ed.undo()
    assert np.array_equal(points(bpy.data.objects["Lattice"].data.points), before)
    bpy.ops.object.mode_set(mode="OBJECT")


def refused(**properties) -> str:
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.isochor.mirror_lattice(**properties)
    return str(caught.value)


def test_refusals_in_plain_words_change_nothing():
    scenes.sphere()
    assert not bpy.ops.isochor.mirror_lattice.poll()
    whole, flat = shaken(name="Whole"), shaken((4, 1, 4), name="Flat")
    whole.select_set(True)
    before = points(whole.data.points)
    assert "“Flat” has one layer of points along Y" in refused(axis="Y")
    assert np.array_equal(points(whole.data.points), before)
    scenes.choose(whole)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lattice.select_all(action="DESELECT")
    assert "No point of “Whole” is selected" in refused(axis="X")
    bpy.ops.object.mode_set(mode="OBJECT")
    whole.shape_key_add(name="Basis")
    whole.active_shape_key.lock_shape = True
    assert "The shape key “Basis” of “Whole” is locked" in refused(axis="X")
    assert np.array_equal(points(whole.data.points), before)
    assert flat.name in bpy.data.objects


def test_linked_points_are_refused(tmp_path):
    shaken(name="Foreign")
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.objects = ["Foreign"]
    lattice = scenes.linked(wanted.objects[0])
    assert "The points of “Foreign” belong to another file" in refused(axis="X")
    override = lattice.override_create(remap_local_usages=True)
    scenes.choose(override)
    assert "The points of “Foreign” belong to another file" in refused(axis="X")
    override.data.override_create(remap_local_usages=True)
    assert "The points of “Foreign” belong to another file" in refused(axis="X")
    bpy.ops.object.make_local(type="SELECT_OBDATA")
    assert bpy.ops.isochor.mirror_lattice(axis="X") == {"FINISHED"}
    assert np.array_equal(grid(override), image(grid(override), 0))
