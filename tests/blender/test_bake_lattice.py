# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to Blender's own Lattice modifier: without the add-on every frame has the very same shape and volume."""

import bpy
import elsewhere
import numpy as np
import pytest
import scenes

FRAMES = 7
EXACT = [
    ("Bernstein", (4, 4, 4)),
    ("Bernstein", (2, 2, 2)),
    ("Bernstein", (3, 4, 2)),
    ("Bernstein", (1, 3, 3)),
    ("B-Spline", (6, 5, 4)),
    ("B-Spline", (3, 2, 7)),
    ("B-Spline", (5, 1, 4)),
]


def cage(basis: str, shape: tuple[int, int, int], size: float = 3.2) -> bpy.types.Object:
    """A lattice whose domain is a cube of this size, squashed, sheared and swung by a keyed shape key."""
    lattice = scenes.lattice_object(shape, name="Cage")
    for axis, points in enumerate(shape):
        domain = points - max(1, min(3, points - 1)) if basis == "B-Spline" else points - 1
        lattice.scale[axis] = size * (points - 1) / domain if points > 1 else size
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash", from_mix=False)
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.3 * z + 0.1, y + 0.15 * x * z, 0.5 * z + 0.1 * x * y)
    for frame, value in ((1, 0.0), (FRAMES // 2, 1.0), (FRAMES, 0.3)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return lattice


def move(obj: bpy.types.Object, far: float) -> None:
    """Keys a small journey with a turn."""
    for frame, place in ((1, 0.0), (FRAMES, far)):
        obj.location, obj.rotation_euler = (place, -place, 0.5 * place), (0.2 * place, 0.3 * place, 0.9 * place)
        obj.keyframe_insert("location", frame=frame)
        obj.keyframe_insert("rotation_euler", frame=frame)


def scene(
    basis: str, shape: tuple[int, int, int], moving: str = "", size: float = 3.2, **inputs
) -> tuple[bpy.types.Object, bpy.types.Object]:
    """The ball and its lattice: of them stands, or moves, what ``moving`` says: "", "both" or "object"."""
    ball = scenes.sphere(20, 12)
    lattice = cage(basis, shape, size)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    ball.scale = (1.0, 1.2, 0.8)
    lattice.scale = [one * other for one, other in zip(lattice.scale, (1.0, 1.2, 0.8), strict=True)]
    lattice.rotation_euler = (0.1, 0.0, 0.15)
    if moving == "both":
        bpy.context.view_layer.update()
        lattice.parent = ball
        lattice.matrix_parent_inverse = ball.matrix_world.inverted()
        move(ball, 2.0)
    if moving == "object":
        move(ball, 0.15)
    bpy.context.scene.frame_set(1)
    scenes.volume_lattice(ball, lattice, Basis=basis, **inputs)
    scenes.choose(ball)
    return ball, lattice


def shapes(obj: bpy.types.Object) -> np.ndarray:
    """(frames, V, 3): what Blender draws of the object."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def bake(**settings) -> set:
    return bpy.ops.isochor.bake(format="LATTICE", **settings)


def data() -> dict[str, int]:
    """How many of everything that a bake makes is in the file."""
    return {kind: len(getattr(bpy.data, kind)) for kind in ("objects", "lattices", "meshes", "actions", "shape_keys")}


def refused(words: str) -> None:
    """Baking raises an error with these words and changes nothing."""
    stacks, before = {obj.name: list(obj.modifiers.keys()) for obj in bpy.data.objects}, data()
    with pytest.raises(RuntimeError, match=words):
        bake()
    assert stacks == {obj.name: list(obj.modifiers.keys()) for obj in bpy.data.objects}
    assert before == data()


def require_same(tmp_path, ball: bpy.types.Object, before: np.ndarray, whole: float | None) -> None:
    """Without the add-on the shapes are these, to 1e-6 of the size, and have this volume where one is given."""
    after = elsewhere.played(tmp_path, ball.name, [float(frame) for frame in range(1, FRAMES + 1)])
    size = np.ptp(before[0], axis=0).max()
    assert np.ptp(before, axis=0).max() > 0.1 * size
    assert np.abs(after - before).max() <= 1e-6 * size
    for shape in after if whole is not None else ():
        assert abs(elsewhere.volume(shape, ball) / whole - 1) <= 1e-6


@pytest.mark.parametrize("moving", ["", "both", "object"])
@pytest.mark.parametrize(("basis", "shape"), EXACT)
def test_without_the_add_on_it_is_the_same_in_every_frame(tmp_path, basis, shape, moving):
    ball, _lattice = scene(basis, shape, moving)
    before, whole = shapes(ball), scenes.volume(ball.data)
    assert bake() == {"FINISHED"}
    ours, native = ball.modifiers
    assert (native.type, native.object.data.users) == ("LATTICE", 1)
    assert not ours.show_viewport
    assert not ours.show_render
    require_same(tmp_path, ball, before, whole)


def test_strength_keyed_and_a_vertex_group_inverted_go_over(tmp_path):
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    group = ball.vertex_groups.new(name="Held")
    for vertex in ball.data.vertices:
        group.add([vertex.index], float(np.clip(vertex.co.x, 0.0, 1.0)), "REPLACE")
    modifier = ball.modifiers[0]
    scenes.set_input(modifier, "Vertex Group", "Held")
    scenes.set_input(modifier, "Invert", True)
    sockets = scenes.part("tool.sockets")
    joined = "." if sockets.data_path(modifier, "Strength").startswith("p") else ""
    path = f'modifiers["{modifier.name}"]{joined}{sockets.data_path(modifier, "Strength")}'
    for frame, value in ((1, 0.4), (FRAMES, 1.0)):
        scenes.set_input(modifier, "Strength", value)
        ball.keyframe_insert(path, frame=frame)
    before, whole = shapes(ball), scenes.volume(ball.data)
    assert bake() == {"FINISHED"}
    require_same(tmp_path, ball, before, whole)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    bag = ball.animation_data.action.layers[0].strips[0].channelbag(ball.animation_data.action_slot)
    assert [curve.data_path for curve in bag.fcurves] == [path]


def test_extended_beyond_a_linear_lattice_it_is_exact_too(tmp_path):
    ball, _lattice = scene("Bernstein", (2, 2, 2), size=1.6, Outside="Extend")
    assert scenes.report(ball, ball.modifiers[0]).vertices_outside > 20
    before, whole = shapes(ball), scenes.volume(ball.data)
    assert bake() == {"FINISHED"}
    require_same(tmp_path, ball, before, whole)


def test_under_an_armature_like_modifier_and_a_subdivision_it_acts_in_its_place(tmp_path):
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    ball.modifiers.new("Cast", "CAST").factor = 0.4
    ball.modifiers.new("Subdivision", "SUBSURF").levels = 1
    ball.modifiers.move(1, 0)
    before = shapes(ball)
    assert bake() == {"FINISHED"}
    assert [modifier.type for modifier in ball.modifiers] == ["CAST", "NODES", "LATTICE", "SUBSURF"]
    require_same(tmp_path, ball, before, None)


def test_between_frames_it_goes_straight(tmp_path):
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    bake()
    one, middle, other = elsewhere.played(tmp_path, ball.name, [2.0, 2.25, 3.0])
    assert np.abs(one - other).max() > 0.01
    assert np.abs(middle - (0.75 * one + 0.25 * other)).max() < 1e-6


def test_two_objects_in_one_lattice_get_one_each(tmp_path):
    ball, lattice = scene("B-Spline", (5, 5, 5))
    other = scenes.sphere(12, 8, name="Other")
    other.scale = (0.5, 0.5, 0.5)
    scenes.volume_lattice(other, lattice, Basis="B-Spline")
    before = shapes(ball), shapes(other)
    scenes.choose(lattice)
    assert bake() == {"FINISHED"}
    assert ball.modifiers[1].object != other.modifiers[1].object
    for obj, shape in zip((ball, other), before, strict=True):
        require_same(tmp_path, obj, shape, scenes.volume(obj.data))


def test_baking_is_one_undo_step_and_freeing_leaves_nothing():
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    shown, before = shapes(ball), data()
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.bake("EXEC_DEFAULT", True, format="LATTICE")
    assert data() != before
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert [modifier.type for modifier in ball.modifiers] == ["NODES"]
    assert data() == before
    bpy.ops.ed.redo()
    ball = bpy.data.objects["Ball"]
    assert [modifier.type for modifier in ball.modifiers] == ["NODES", "LATTICE"]
    scenes.choose(ball)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert [modifier.type for modifier in ball.modifiers] == ["NODES"]
    assert ball.modifiers[0].show_viewport
    assert ball.modifiers[0].show_render
    assert data() == before
    assert np.abs(shapes(ball) - shown).max() < 1e-6


def test_baking_again_in_whatever_format_replaces_the_bake_before(tmp_path):
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    shown, before = shapes(ball), data()
    for kind, types in (
        ("LATTICE", ["NODES", "LATTICE"]),
        ("LATTICE", ["NODES", "LATTICE"]),
        ("PC2", ["NODES", "MESH_CACHE"]),
        ("SHAPE_KEYS", ["NODES"]),
        ("SHAPE_KEYS", ["NODES"]),
        ("LATTICE", ["NODES", "LATTICE"]),
        ("SHAPE_KEYS", ["NODES"]),
        ("PC2", ["NODES", "MESH_CACHE"]),
    ):
        assert bpy.ops.isochor.bake(format=kind, directory=str(tmp_path)) == {"FINISHED"}
        assert [modifier.type for modifier in ball.modifiers] == types
        assert np.abs(shapes(ball) - shown).max() < 2e-6, kind
        assert len(bpy.data.lattices) == before["lattices"] + (kind == "LATTICE")
        assert (ball.data.shape_keys is not None) == (kind == "SHAPE_KEYS")
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert data() == before


def test_a_copy_keeps_the_lattice_that_it_shares_when_the_bake_is_freed():
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    before = len(bpy.data.lattices)
    bake()
    shown = shapes(ball)
    twin = ball.copy()
    bpy.context.scene.collection.objects.link(twin)
    scenes.choose(ball)
    bpy.ops.isochor.free_bake()
    assert [modifier.type for modifier in twin.modifiers] == ["NODES", "LATTICE"]
    assert np.abs(shapes(twin) - shown).max() < 1e-6
    scenes.choose(twin)
    bpy.ops.isochor.free_bake()
    assert len(bpy.data.lattices) == before


def test_a_bake_that_is_broken_off_leaves_everything_as_it_was():
    ball, _lattice = scene("Bernstein", (4, 4, 4))
    bpy.context.scene.frame_set(5)
    before = data()
    frames, bake_lattice = scenes.part("tool.frames"), scenes.part("tool.bake_lattice")
    bake = bake_lattice.bake(bpy.context, frames.targets([ball]), 1, FRAMES)
    assert [next(bake).moment.frame, next(bake).moment.frame] == [1, 2]
    bake.close()
    assert data() == before
    assert bpy.context.scene.frame_current == 5
    assert ball.modifiers[0].show_viewport


@pytest.mark.parametrize(("basis", "shape"), [("Bernstein", (5, 4, 4)), ("Bernstein", (2, 3, 9))])
def test_a_higher_degree_is_refused(basis, shape):
    scene(basis, shape)
    refused("points: Blender's own Lattice modifier goes up to 4 on each side")


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize(("basis", "shape"), [("Bernstein", (4, 4, 4)), ("B-Spline", (5, 5, 5))])
def test_vertices_outside_stay_where_they_are(tmp_path, basis, shape, masked):
    ball, _lattice = scene(basis, shape, size=1.6)
    if masked:
        group = ball.vertex_groups.new(name="Held")
        for vertex in ball.data.vertices:
            group.add([vertex.index], float(np.clip(vertex.co.x, 0.0, 1.0)), "REPLACE")
        scenes.set_input(ball.modifiers[0], "Vertex Group", "Held")
        scenes.set_input(ball.modifiers[0], "Invert", True)
        scenes.set_input(ball.modifiers[0], "Strength", 0.8)
    before, groups = shapes(ball), ball.vertex_groups.keys()
    still = np.ptp(before, axis=0).max(axis=1) == 0.0
    assert 20 < np.count_nonzero(still) < 200
    assert bake() == {"FINISHED"}
    require_same(tmp_path, ball, before, None)
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert ball.vertex_groups.keys() == groups


def test_vertices_outside_that_no_native_lattice_can_follow_are_refused():
    ball, _lattice = scene("Bernstein", (4, 4, 4), size=1.6, Outside="Extend")
    refused("vertices of “Ball” are outside the lattice")
    scenes.set_input(ball.modifiers[0], "Outside", "Keep")
    ball.modifiers.new("Subdivision", "SUBSURF")
    ball.modifiers.move(1, 0)
    refused("vertices of “Ball” are outside the lattice")


def test_vertices_that_enter_the_lattice_on_the_way_are_refused():
    scene("Bernstein", (4, 4, 4), moving="object", size=1.9)
    refused("other vertices of “Ball” are outside the lattice than before")


def test_two_of_ours_a_missing_lattice_and_a_linked_object_are_refused(tmp_path):
    ball, lattice = scene("Bernstein", (4, 4, 4))
    second = scenes.volume_lattice(ball, lattice)
    scenes.choose(ball)
    refused("has 2 Volume Lattices")
    second.show_render = False
    assert bake() == {"FINISHED"}
    bpy.ops.isochor.free_bake()
    bpy.data.objects.remove(lattice)
    refused("No lattice: pick a Lattice object")
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    scenes.choose(wanted.objects[0])
    refused("is linked from another file")
