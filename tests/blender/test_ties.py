# SPDX-License-Identifier: GPL-3.0-or-later
"""Adjacent lattices tied together: no gap, no crease, also while one is edited, animated, corrected, saved, undone."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
import tie_scenes
from tie_scenes import deformed, error, joint, push, tied_bar

SMOOTH = {"Bernstein": 0.05, "B-Spline": 0.05}
"""Jump of the slope over two steps that the curvature alone makes in these scenes."""


def piecewise(obj: bpy.types.Object, blocks: list[bpy.types.Object], basis: str) -> np.ndarray:
    """Each vertex as the block moves it that it stands in at rest, by the oracle."""
    rest = scenes.positions(obj.data)
    found = rest.copy()
    for number, lattice in list(enumerate(blocks))[::-1]:
        low, high = tie_scenes.ENDS[number : number + 2]
        here = (rest[:, 0] >= low - 1e-6) & (rest[:, 0] <= high + 1e-6)
        inside = np.clip(rest[here], (low + 1e-7, -9, -9), (high - 1e-7, 9, 9))
        found[here] = lattice_oracle.deformed(obj, lattice, inside, basis)
    return found


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
@pytest.mark.parametrize("continuity", ["C0", "C1"])
def test_neighbours_follow_an_edit(continuity, basis):
    obj, blocks, _modifiers = tied_bar(continuity, basis, Preserve=0.0)
    push(blocks[0], -1, (0.1, 0.2, 0.1))
    push(blocks[2], 0, (-0.05, -0.2, 0.1))
    for number in (1, 2):
        jump, moved = joint(obj, number)
        assert moved > 0.02
        if continuity == "C1":
            assert jump < SMOOTH[basis]
        else:
            assert 3.0 > jump > (SMOOTH[basis] if basis == "Bernstein" else 0.0)
    assert np.abs(scenes.evaluated_positions(obj) - piecewise(obj, blocks, basis)).max() < 5e-6


@pytest.mark.parametrize("kind", ["KEY_BSPLINE", "KEY_CARDINAL", "KEY_CATMULL_ROM", "KEY_LINEAR"])
def test_blocks_with_the_basis_of_blender_join_without_a_crease(kind):
    obj = tie_scenes.bar()
    blocks = tie_scenes.blocks()
    for lattice in blocks:
        for axis in "uvw":
            setattr(lattice.data, f"interpolation_type_{axis}", kind)
        scenes.volume_lattice(obj, lattice, Basis="Blender")
    tie_scenes.select(*blocks)
    assert bpy.ops.isochor.tie_lattices(continuity="C1") == {"FINISHED"}
    push(blocks[0], -1, (0.1, 0.2, 0.1))
    push(blocks[2], 0, (-0.05, -0.2, 0.1))
    for number in (1, 2):
        jump, moved = joint(obj, number)
        assert moved > 0.02
        assert jump < 0.1
    assert error(obj) <= 1e-6
    blocks[1].data.interpolation_type_v = "KEY_LINEAR" if kind != "KEY_LINEAR" else "KEY_BSPLINE"
    bpy.context.view_layer.update()
    texts = [text for modifier in obj.modifiers for text in scenes.report(obj, modifier).problems]
    assert any("cannot be tied" in text for text in texts)


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_correction_leaves_the_joints_alone_and_is_exact(basis):
    obj, blocks, modifiers = tied_bar("C1", basis)
    push(blocks[0], -1, (0.1, 0.2, 0.1))
    push(blocks[1], 2, (0.0, 0.2, 0.3))
    lost = scenes.report(obj, modifiers[-1]).volumes
    assert abs(lost.before / lost.target - 1.0) > 1e-3
    assert error(obj) <= 1e-6
    assert scenes.report(obj, modifiers[-1]).problems == ()
    for number in (1, 2):
        assert joint(obj, number)[0] < SMOOTH[basis]


def test_where_nothing_moves_nothing_moves_to_the_last_bit():
    obj, blocks, modifiers = tied_bar("C1")
    order = [2, 1, 0]
    for place, number in enumerate(order):
        obj.modifiers.move(list(obj.modifiers).index(modifiers[number]), place)
    for number, modifier in enumerate(modifiers):
        scenes.set_input(modifier, "Preserve", float(number == 0))
    push(blocks[0], 0, (0.4, 0.0, 0.0))
    rest, now = scenes.positions(obj.data), scenes.evaluated_positions(obj)
    beyond = rest[:, 0] > tie_scenes.ENDS[1]
    assert np.abs(now - rest)[~beyond].max() > 0.2
    assert np.array_equal(now[beyond], rest[beyond])
    assert error(obj) <= 1e-6
    assert joint(obj, 1)[0] < 0.05


def keyed(lattice: bpy.types.Object, layer: int) -> bpy.types.ShapeKey:
    """A shape key that moves a layer, keyed from 0 at frame 1 to 1 at frame 10."""
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Crumple")
    for index, point in enumerate(key.data):
        if index % lattice.data.points_u == layer % lattice.data.points_u:
            point.co.z += 0.3 * (1.0 + point.co.y)
    for frame, value in ((1, 0.0), (10, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return key


def test_animation_stays_tied_and_writes_nothing():
    obj, blocks, _modifiers = tied_bar("C1")
    keyed(blocks[0], -1)
    bpy.context.scene.frame_set(1)
    bpy.context.view_layer.update()
    before = [deformed(lattice) for lattice in blocks]
    for frame in (4, 10, 7):
        bpy.context.scene.frame_set(frame)
        jump, moved = joint(obj, 1)
        assert moved > 0.05
        assert jump < 0.05
        assert error(obj) <= 1e-6
    assert all(np.array_equal(deformed(one), other) for one, other in zip(blocks, before, strict=True))


def test_keys_of_one_name_follow_one_another():
    obj, blocks, _modifiers = tied_bar("C1", Preserve=0.0)
    for lattice in blocks[:2]:
        lattice.shape_key_add(name="Basis")
        lattice.shape_key_add(name="Dent")
    bpy.context.view_layer.update()
    leader, follower = (lattice.data.shape_keys.key_blocks for lattice in blocks[:2])
    for index, point in enumerate(leader["Dent"].data):
        if index % 4 == 3:
            point.co.z -= 0.4
    blocks[0].data.update_tag()
    bpy.context.view_layer.update()
    for name in ("Dent", "Basis"):
        here, there = (np.array([tuple(point.co) for point in keys[name].data]) for keys in (leader, follower))
        assert np.abs(there[::5, 1:] - here[3::4, 1:]).max() < 1e-6
    for value in (0.5, 1.0):
        for keys in (leader, follower):
            keys["Dent"].value = value
        bpy.context.view_layer.update()
        assert joint(obj, 1)[1] > 0.1
        assert np.abs(scenes.evaluated_positions(obj) - piecewise(obj, blocks, "Bernstein")).max() < 5e-6


def test_the_lattice_whose_joint_is_edited_leads():
    obj, blocks, _modifiers = tied_bar("C0", Preserve=0.0)
    record = scenes.part("tool.tie_record")
    (tied,) = record.of(blocks[0])
    assert tied.leads
    push(blocks[1], 0, (0.0, 0.0, 0.2))
    assert not record.of(blocks[0])[0].leads
    assert deformed(blocks[0])[3, 2] > -0.4
    push(blocks[1], 2, (0.0, 0.0, 0.2))
    push(blocks[0], -1, (0.0, 0.0, 0.2))
    assert record.of(blocks[0])[0].leads
    push(blocks[1], 2, (0.0, 0.0, -0.1))
    assert record.of(blocks[0])[0].leads
    assert joint(obj, 1)[1] > 0.2


def test_edit_mode_shows_the_neighbour_live():
    obj, blocks, _modifiers = tied_bar("C1", Preserve=0.0)
    scenes.choose(blocks[0])
    bpy.ops.object.mode_set(mode="EDIT")
    push(blocks[0], -1, (0.0, 0.0, 0.3))
    assert deformed(blocks[1])[0, 2] > -0.4
    assert joint(obj, 1)[0] < 0.05
    there = deformed(blocks[1])
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert np.array_equal(deformed(blocks[1]), there)
    assert joint(obj, 1)[1] > 0.1


def test_an_edit_is_undone_in_one_step_on_both_sides():
    _obj, blocks, _modifiers = tied_bar("C1")
    bpy.ops.ed.undo_push(message="Tied")
    before = [deformed(lattice) for lattice in blocks]
    for index, point in enumerate(blocks[0].data.points):
        if index % 4 == 3:
            point.co_deform.z += 0.2
    bpy.ops.ed.undo_push(message="Edited")
    bpy.context.view_layer.update()
    edited = [deformed(lattice) for lattice in blocks]
    assert not np.array_equal(edited[1], before[1])
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    blocks = [bpy.data.objects[f"Block {number}"] for number in range(3)]
    assert all(np.array_equal(deformed(one), other) for one, other in zip(blocks, before, strict=True))
    bpy.ops.ed.redo()
    bpy.context.view_layer.update()
    blocks = [bpy.data.objects[f"Block {number}"] for number in range(3)]
    assert np.array_equal(deformed(blocks[0]), edited[0])
    assert np.abs(deformed(blocks[1]) - edited[1]).max() < 1e-6
    assert joint(bpy.data.objects["Bar"], 1)[1] > 0.05


def test_tying_is_undone_in_one_step():
    tied_bar("C1")
    bpy.ops.ed.undo_push(message="Tied")
    tie_scenes.select(*[bpy.data.objects[f"Block {number}"] for number in (0, 1)])
    bpy.ops.isochor.untie_lattices()
    record = scenes.part("tool.tie_record")
    bpy.ops.ed.undo_push(message="Untied")
    assert [len(record.of(bpy.data.objects[f"Block {number}"])) for number in range(3)] == [0, 1, 1]
    bpy.ops.ed.undo()
    assert [len(record.of(bpy.data.objects[f"Block {number}"])) for number in range(3)] == [1, 2, 1]


def test_ties_survive_the_file_and_copying_together(tmp_path):
    _obj, blocks, _modifiers = tied_bar("C1")
    record = scenes.part("tool.tie_record")
    keyed(blocks[0], -1)
    place = str(tmp_path / "tied.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    bpy.context.scene.frame_set(8)
    jump, moved = joint(bpy.data.objects["Bar"], 1)
    assert moved > 0.05
    assert jump < 0.05
    blocks = [bpy.data.objects[f"Block {number}"] for number in range(3)]
    alone = blocks[0].copy()
    assert record.of(alone) == []
    bpy.data.objects.remove(alone)
    tie_scenes.select(*blocks)
    bpy.ops.object.duplicate()
    copies = [bpy.data.objects[f"Block {number}.001"] for number in range(3)]
    assert [tied.other for tied in record.of(copies[1])] == [copies[0], copies[2]]
    assert [tied.other for tied in record.of(blocks[1])] == [blocks[0], blocks[2]]
    scenes.empty_file()
    with bpy.data.libraries.load(place) as (_source, target):
        target.objects = ["Bar"]
    bpy.context.scene.collection.objects.link(target.objects[0])
    first = bpy.data.objects["Block 0"]
    assert [tied.other.name for tied in record.of(first)] == ["Block 1"]
    bpy.context.scene.frame_set(8)
    assert joint(bpy.data.objects["Bar"], 1)[1] > 0.05
    assert joint(bpy.data.objects["Bar"], 1)[0] < 0.05


def test_lattices_that_do_not_meet_are_refused_with_the_distance():
    blocks = tie_scenes.blocks()
    blocks[2].location.x += 0.25
    blocks[0].location.x -= 0.5
    bpy.context.view_layer.update()
    tie_scenes.select(*blocks)
    with pytest.raises(RuntimeError, match=r"0\.25 apart"):
        bpy.ops.isochor.tie_lattices()
    blocks[0].location.x += 0.5
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.tie_lattices() == {"FINISHED"}
    record = scenes.part("tool.tie_record")
    assert [len(record.of(lattice)) for lattice in blocks] == [1, 1, 0]


@pytest.mark.parametrize(
    ("shapes", "text"),
    [
        (((4, 3, 3), (5, 4, 3), (4, 4, 3)), "same resolution"),
        (((4, 3, 3), (3, 3, 3), (4, 3, 3)), "too few points"),
    ],
)
def test_lattices_whose_points_do_not_go_together_are_refused(shapes, text):
    tie_scenes.select(*tie_scenes.blocks(shapes))
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.isochor.tie_lattices(continuity="C1")
    assert all(scenes.part("tool.tie_record").of(obj) == [] for obj in bpy.data.objects)


def test_blocks_turned_against_each_other_are_matched_by_where_their_faces_are():
    obj = tie_scenes.bar()
    blocks = tie_scenes.blocks(((4, 3, 3), (3, 3, 5), (4, 3, 3)))
    blocks[1].rotation_euler = (0.0, np.pi / 2.0, 0.0)
    blocks[1].scale = (1.0, 1.0, 1.5)
    bpy.context.view_layer.update()
    for lattice in blocks:
        scenes.volume_lattice(obj, lattice, Preserve=0.0)
    tie_scenes.select(*blocks)
    assert bpy.ops.isochor.tie_lattices() == {"FINISHED"}
    push(blocks[0], -1, (0.1, 0.2, 0.1))
    push(blocks[2], 0, (0.1, 0.1, -0.2))
    for number in (1, 2):
        jump, moved = joint(obj, number)
        assert moved > 0.05
        assert jump < 0.05


def test_moved_apart_they_say_so_and_go_on():
    obj, blocks, modifiers = tied_bar("C1")
    push(blocks[0], -1, (0.0, 0.0, 0.1))
    blocks[0].location.x -= 0.3
    bpy.context.view_layer.update()
    assert any("do not meet" in text for text in scenes.report(obj, modifiers[1]).problems)
    assert error(obj) <= 1e-6
    blocks[0].location.x += 0.3
    bpy.context.view_layer.update()
    assert scenes.report(obj, modifiers[1]).problems == ()


def test_sidebar_names_the_neighbours():
    _obj, blocks, _modifiers = tied_bar("C1")
    texts = scenes.part("ui.sidebar").notes_on_ties(blocks[1])
    assert texts == ["Tied to “Block 0” (C1), which leads.", "Tied to “Block 2” (C1), which follows."]


def test_renders_are_tied_without_a_write(monkeypatch, tmp_path):
    obj, blocks, _modifiers = tied_bar("C1")
    keyed(blocks[0], -1)
    bpy.context.scene.frame_set(9)
    shown = scenes.evaluated_positions(obj)
    written = []
    points = scenes.part("tool.tie_points")
    monkeypatch.setattr(points, "write", lambda *given: written.append(given) or False)
    seen = []

    def look(_scene, depsgraph):
        if depsgraph.mode == "RENDER":
            seen.append(scenes.positions(scenes.get_input(obj.modifiers[-1], "Render Result").data))

    bpy.app.handlers.frame_change_post.append(look)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.filepath = str(tmp_path / "tied.png")
    scene.frame_start = scene.frame_end = 9
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.frame_change_post.remove(look)
    assert len(seen) == 1
    assert np.abs(seen[0] - shown).max() < 1e-6
    assert written == []


def test_removing_a_block_takes_its_lattice_and_its_ties_along():
    obj = tie_scenes.bar()
    scenes.choose(obj)
    lattices = []
    for number in (0, 1):
        assert bpy.ops.isochor.add(resolution=(4, 3, 3)) == {"FINISHED"}
        lattice = scenes.get_input(obj.modifiers[-1], "Lattice")
        low, high = tie_scenes.ENDS[number : number + 2]
        lattice.location, lattice.scale = ((low + high) / 2.0, 0.0, 0.0), (high - low, 1.0, 1.0)
        lattices.append(lattice)
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.tie_lattices() == {"FINISHED"}
    record = scenes.part("tool.tie_record")
    assert len(record.of(lattices[0])) == 1
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert [found.name for found in bpy.data.objects if found.type == "LATTICE"] == [lattices[0].name]
    assert not record.is_tied(lattices[0])


@pytest.mark.parametrize("continuity", ["C0", "C1"])
def test_four_quarters_around_one_edge_stay_together(continuity):
    """Ferrier's blocks, one for each quarter of the body as seen from above."""
    ball = scenes.sphere()
    ball.scale = (0.95, 0.95, 0.95)
    quarters = []
    for x, y in ((-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)):
        lattice = scenes.lattice_object((4, 4, 3), name=f"Quarter {len(quarters)}", size=1.2)
        lattice.location, lattice.scale.z = (x, y, 0.0), 2.4
        quarters.append(lattice)
        scenes.volume_lattice(ball, lattice)
    tie_scenes.select(*quarters)
    assert bpy.ops.isochor.tie_lattices(continuity=continuity) == {"FINISHED"}
    for number, lattice in enumerate((quarters[0], quarters[2])):
        for point in lattice.data.points:
            at = lattice.matrix_world @ point.co
            if abs(at.x) < 0.1 and abs(at.y) < 0.1 and at.z > 0.5:
                point.co_deform.z += 0.3
                point.co_deform.x -= 0.1 * number
        lattice.data.update_tag()
        bpy.context.view_layer.update()
        edges = []
        for one in quarters:
            for point in one.data.points:
                at = one.matrix_world @ point.co
                if abs(at.x) < 0.1 and abs(at.y) < 0.1 and at.z > 0.5:
                    edges.append(tuple(one.matrix_world @ point.co_deform))
        assert len(edges) == 4
        assert np.ptp(np.array(edges), axis=0).max() < 1e-6
        assert edges[0][2] > 1.2 + 0.5
        assert error(ball) <= 1e-6
        assert all(scenes.report(ball, modifier).problems == () for modifier in ball.modifiers)
