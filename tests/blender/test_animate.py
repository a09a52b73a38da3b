# SPDX-License-Identifier: GPL-3.0-or-later
"""Squash, taper, twist and bend: what they do to control points, by the laws of geometry, and to the mesh's volume."""

import math

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix
from numpy.typing import NDArray

PLACES = {"Bottom": 0.0, "Centre": 0.5, "Top": 1.0}
AXES = "XYZ"
SIZES = (0.7, 1.6, 2.9)


class Cage:
    """A lattice object that stands askew and has another size on each axis, and what Animate makes of its points."""

    def __init__(self, shape=(5, 6, 7), basis: str = "Bernstein", sizes=SIZES) -> None:
        self.ball = scenes.sphere()
        self.ball.matrix_world = Matrix.LocRotScale((0.4, -1.0, 2.0), Euler((0.3, 1.1, -0.6)), (0.5, 1.5, 0.8))
        self.lattice = scenes.lattice_object(shape)
        self.lattice.matrix_world = Matrix.LocRotScale((1.0, -2.0, 0.5), Euler((0.7, -0.4, 1.3)), sizes)
        self.shape, self.sizes, self.basis = shape, np.array(sizes), basis
        self.modifier = scenes.volume_lattice(self.ball, self.lattice, Basis=basis, Preserve=0.0)

    def world(self, **inputs: object) -> NDArray[np.float64]:
        """(nu, nv, nw, 3) control points that shaped the mesh, to world."""
        for name, value in inputs.items():
            scenes.set_input(self.modifier, name.replace("_", " "), value)
        bpy.context.view_layer.update()
        matrix = np.array(self.ball.matrix_world, np.float64)
        return scenes.report(self.ball, self.modifier).asked @ matrix[:3, :3].T + matrix[:3, 3]

    def framed(self, axis: str, **inputs: object) -> NDArray[np.float64]:
        """The same along the lattice's own upright directions, from its middle: (layers along ``axis``, points of a
        layer, 3), coordinates along the axis first, then along the two that follow it in turn, in world lengths."""
        matrix = np.array(self.lattice.matrix_world, np.float64)
        directions = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
        turn = np.roll(np.arange(3), -AXES.index(axis))
        local = (self.world(Axis=axis, **inputs) - matrix[:3, 3]) @ directions[:, turn]
        return np.moveaxis(local, AXES.index(axis), 0).reshape(self.shape[AXES.index(axis)], -1, 3)

    def length(self, axis: str) -> float:
        """Length of the domain along the axis."""
        index = AXES.index(axis)
        intervals = self.shape[index] - 1
        inside = intervals - 2 if self.basis == "B-Spline" else intervals
        return float(self.sizes[index] * inside / intervals)

    def places(self, axis: str) -> NDArray[np.float64]:
        """Of each layer: 0 at the domain's bottom, 1 at its top."""
        index = AXES.index(axis)
        grid = (np.arange(self.shape[index]) / (self.shape[index] - 1) - 0.5) * self.sizes[index]
        return grid / self.length(axis) + 0.5


def angle_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Counter-clockwise turn from one set of points in the plane to another, both about the origin."""
    return float(np.angle(np.sum((other[:, 0] + 1j * other[:, 1]) * np.conj(one[:, 0] + 1j * one[:, 1]))))


close = pytest.approx
TINY = 2e-6
CASES = [("X", "Bernstein"), ("Y", "Bernstein"), ("Z", "Bernstein"), ("X", "B-Spline"), ("Z", "B-Spline")]


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_the_defaults_move_no_bit(basis, monkeypatch):
    cage = Cage(basis=basis)
    for point in cage.lattice.data.points:
        point.co_deform.z *= 0.8
    bpy.context.view_layer.update()
    update = scenes.part("tool.update")
    grid, evaluated = scenes.part("core.grid"), scenes.part("tool.evaluated")
    asked = scenes.report(cage.ball, cage.modifier).asked
    points = evaluated.lattice_points(cage.lattice)
    own = grid.relative_transform(evaluated.matrix(cage.ball), evaluated.matrix(cage.lattice), ("", ""))
    rest = grid.Grid(points.shape, points.low, points.high, basis, own)
    assert np.array_equal(asked, grid.control_points(rest, points.deformed))
    monkeypatch.setattr(update.shaping, "shaped", lambda *_: pytest.fail("the defaults cost time"))
    for name, value in (("Axis", "X"), ("Pivot", "Top"), ("Bend Direction", 1.0)):
        scenes.set_input(cage.modifier, name, value)
    bpy.context.view_layer.update()
    assert np.array_equal(asked, scenes.report(cage.ball, cage.modifier).asked)


@pytest.mark.parametrize("pivot", PLACES)
@pytest.mark.parametrize(("axis", "basis"), CASES)
def test_squash_scales_lengths_along_the_axis_and_the_pivot_stays(axis, basis, pivot):
    cage = Cage(basis=basis)
    rest = cage.framed(axis)
    moved = cage.framed(axis, Squash=0.4, Pivot=pivot)
    assert np.abs(moved[..., 1:] - rest[..., 1:]).max() < TINY
    assert np.abs(np.diff(moved[:, :, 0], axis=0) - 0.4 * np.diff(rest[:, :, 0], axis=0)).max() < TINY
    fixed = cage.length(axis) * (PLACES[pivot] - 0.5)
    assert np.abs((moved[..., 0] - fixed) - 0.4 * (rest[..., 0] - fixed)).max() < TINY


@pytest.mark.parametrize("pivot", PLACES)
@pytest.mark.parametrize(("axis", "basis"), CASES)
def test_taper_scales_each_section_linearly(axis, basis, pivot):
    cage = Cage(basis=basis)
    rest = cage.framed(axis)
    moved = cage.framed(axis, Taper=-0.6, Pivot=pivot)
    assert np.abs(moved[..., 0] - rest[..., 0]).max() < TINY
    scale = 1.0 - 0.6 * (cage.places(axis) - PLACES[pivot])
    assert np.abs(moved[..., 1:] - scale[:, None, None] * rest[..., 1:]).max() < TINY


def test_taper_ends_in_a_point_and_does_not_turn_inside_out():
    cage = Cage()
    moved = cage.framed("Z", Taper=-2.0)
    beyond = cage.places("Z") >= 0.5
    assert np.abs(moved[beyond][..., 1:]).max() < TINY
    assert np.ptp(moved[~beyond][..., 1:], axis=1).min() > 0.1


@pytest.mark.parametrize("pivot", PLACES)
@pytest.mark.parametrize(("axis", "basis"), CASES)
def test_twist_turns_each_section_rigidly_and_by_its_whole_angle_from_end_to_end(axis, basis, pivot):
    cage = Cage(basis=basis)
    rest = cage.framed(axis)
    twist = math.radians(100.0)
    moved = cage.framed(axis, Twist=twist, Pivot=pivot)
    assert np.abs(moved[..., 0] - rest[..., 0]).max() < TINY
    for before, after in zip(rest, moved, strict=True):
        distances = [np.linalg.norm(p[:, None, 1:] - p[None, :, 1:], axis=-1) for p in (before, after)]
        assert np.abs(distances[0] - distances[1]).max() < TINY
    turns = [angle_between(before[:, 1:], after[:, 1:]) for before, after in zip(rest, moved, strict=True)]
    places = cage.places(axis)
    assert np.abs(np.array(turns) - twist * (places - PLACES[pivot])).max() < TINY
    whole = (turns[-1] - turns[0]) / (places[-1] - places[0])
    assert whole == close(twist, abs=TINY)
    if basis == "Bernstein":
        assert turns[-1] - turns[0] == close(twist, abs=TINY)


def sections(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(layers, 3) the middle of each layer of points, and the direction at right angles to its plane, upwards."""
    middles = points.mean(axis=1)
    normals = np.array([np.linalg.svd(layer - middle)[2][2] for layer, middle in zip(points, middles, strict=True)])
    upwards = np.gradient(middles, axis=0)
    return middles, normals * np.sign(np.einsum("ij,ij->i", normals, upwards))[:, None]


@pytest.mark.parametrize("pivot", PLACES)
@pytest.mark.parametrize(("axis", "basis"), CASES)
def test_bend_makes_an_arc_of_the_axis_with_upright_rigid_sections(axis, basis, pivot):
    cage = Cage(basis=basis)
    rest = cage.framed(axis)
    bend, direction = math.radians(110.0), math.radians(35.0)
    moved = cage.framed(axis, Bend=bend, Bend_Direction=direction, Pivot=pivot)
    middles, normals = sections(moved)
    towards = np.array([0.0, math.cos(direction), math.sin(direction)])
    fixed = np.array([cage.length(axis) * (PLACES[pivot] - 0.5), 0.0, 0.0])
    radius = cage.length(axis) / bend
    centre = fixed + radius * towards
    assert np.abs(np.linalg.norm(middles - centre, axis=1) - radius).max() < TINY
    assert np.abs((middles - centre) @ np.cross((1.0, 0.0, 0.0), towards)).max() < TINY
    for before, after in zip(rest, moved, strict=True):
        distances = [np.linalg.norm(p[:, None] - p[None], axis=-1) for p in (before, after)]
        assert np.abs(distances[0] - distances[1]).max() < TINY
    # Tangents: at right angles to the way to the centre, turned by the arc's share, the arc as long as the axis was.
    assert np.abs(np.einsum("ij,ij->i", normals, middles - centre)).max() < TINY
    turns = np.unwrap(np.arctan2(normals @ towards, normals[:, 0]))
    assert np.abs(turns - bend * (cage.places(axis) - PLACES[pivot])).max() < TINY
    arc = radius * np.diff(turns)
    assert np.abs(arc - np.diff(rest[:, 0, 0])).max() < TINY


def test_bent_pivot_end_keeps_its_place_and_tangent():
    for pivot, layer in (("Bottom", 0), ("Top", -1)):
        cage = Cage()
        rest = cage.framed("Y")[layer]
        moved = cage.framed("Y", Bend=2.0, Bend_Direction=-0.8, Pivot=pivot)[layer]
        assert np.abs(moved - rest).max() < TINY


def test_a_small_bend_is_close_to_none():
    cage = Cage()
    rest = cage.framed("Z")
    assert np.abs(cage.framed("Z", Bend=1e-7) - rest).max() < 1e-6
    half = cage.framed("Z", Bend=1e-3)[-1].mean(axis=0) - rest[-1].mean(axis=0)
    assert half[1] == close(cage.length("Z") * 1e-3 / 2.0, rel=1e-3)


def test_the_bend_direction_of_each_axis_is_the_next_axis_in_turn():
    for axis, following in (("X", 1), ("Y", 2), ("Z", 0)):
        cage = Cage()
        before = cage.world(Axis=axis)
        after = cage.world(Bend=0.5)
        column = np.array(cage.lattice.matrix_world)[:3, following]
        way = np.moveaxis(after - before, AXES.index(axis), 0)[-1].reshape(-1, 3).mean(axis=0)
        sideways = way @ column / np.linalg.norm(column)
        assert sideways > 0.9 * np.linalg.norm(way)


def test_all_four_act_one_after_the_other_squash_taper_twist_bend():
    """Each on what the one before left: shown by doing the same with Blender's own matrices, section by section."""
    cage = Cage(basis="B-Spline")
    given = {"Squash": 0.6, "Taper": 0.7, "Twist": 1.1, "Bend": 0.9, "Bend_Direction": 2.2}
    rest = cage.framed("Z")
    moved = cage.framed("Z", **given, Pivot="Centre")
    length = 0.6 * cage.length("Z")
    radius = length / 0.9
    hinge = Matrix.Rotation(2.2, 4, "X")
    for place, before, after in zip(cage.places("Z") - 0.5, rest, moved, strict=True):
        roll = Matrix.Rotation(1.1 * place, 4, "X") @ Matrix.Diagonal((0.0, 1 + 0.7 * place, 1 + 0.7 * place, 1.0))
        swing = Matrix.Translation((0, radius, 0)) @ Matrix.Rotation(0.9 * place, 4, "Z")
        swing = swing @ Matrix.Translation((0, -radius, 0))
        whole = hinge @ swing @ hinge.inverted() @ roll
        expected = np.array([tuple(whole @ Matrix.Translation(point).to_translation()) for point in before])
        assert np.abs(after - expected).max() < 2 * TINY


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_points_dragged_beyond_the_ends_follow_the_end_rigidly_along_its_tangent(basis):
    cage = Cage(basis=basis)
    shape = cage.shape
    top = [i for i in range(math.prod(shape)) if i // (shape[0] * shape[1]) == shape[2] - 1]
    still = cage.framed("Z", Taper=0.5, Twist=0.8, Bend=1.2)
    for index in top:
        cage.lattice.data.points[index].co_deform.z += 0.4
    moved = cage.framed("Z")
    normals = sections(still)[1]
    assert np.abs(moved[:-1] - still[:-1]).max() < TINY
    assert np.abs(moved[-1] - (still[-1] + 0.4 * SIZES[2] * normals[-1])).max() < 2 * TINY


def test_in_a_sheared_lattice_the_axis_line_keeps_its_length_and_sections_stay_rigid():
    cage = Cage(shape=(5, 5, 7))
    rigid = Matrix.LocRotScale((1.0, -2.0, 0.5), Euler((0.7, -0.4, 1.3)), (1.0, 1.2, 2.0))
    sheared = rigid @ Matrix(((1, 0.2, 0.3, 0), (0, 1, 0.1, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    cage.lattice.parent = parent
    cage.lattice.matrix_parent_inverse = sheared
    cage.lattice.matrix_basis = Matrix.Identity(4)
    before, bent = cage.world(), cage.world(Bend=1.0)
    steps = [np.linalg.norm(np.diff(points[2, 2], axis=0), axis=1) for points in (before, bent)]
    angle = 1.0 / (cage.shape[2] - 1)
    assert np.abs(steps[1] - steps[0] * math.sin(angle / 2) / (angle / 2)).max() < TINY
    twisted = cage.world(Bend=0.0, Twist=1.0)
    along = np.array(cage.lattice.matrix_world)[:3, 2]
    along /= np.linalg.norm(along)
    assert np.abs((twisted - before) @ along).max() < TINY
    middle = np.array(cage.lattice.matrix_world)[:3, 3]
    across = [
        np.linalg.norm((p - middle) - ((p - middle) @ along)[..., None] * along, axis=-1) for p in (before, twisted)
    ]
    assert np.abs(across[1] - across[0]).max() < TINY


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
@pytest.mark.parametrize("pivot", PLACES)
def test_the_volume_stays_with_all_four_at_once(basis, pivot):
    ball = scenes.sphere(48, 32)
    lattice = scenes.lattice_object(6, size=2.6 if basis == "Bernstein" else 2.6 * 5 / 3)
    modifier = scenes.volume_lattice(ball, lattice, Basis=basis, Preserve=0.0, Pivot=pivot)
    for name, value in (("Squash", 0.6), ("Taper", -0.4), ("Twist", 1.3), ("Bend", 0.9), ("Bend Direction", 0.5)):
        scenes.set_input(modifier, name, value)
    bpy.context.view_layer.update()
    whole = scenes.volume(ball.data)
    assert scenes.evaluated_volume(ball) < 0.8 * whole
    shapes = []
    for axes in ((1.0, 1.0, 1.0), (1.0, 1.0, 0.0)):
        scenes.set_input(modifier, "Preserve", 1.0)
        scenes.set_input(modifier, "Axes", axes)
        bpy.context.view_layer.update()
        assert scenes.report(ball, modifier).problems == ()
        assert abs(scenes.evaluated_volume(ball) / whole - 1.0) <= 1e-6
        shapes.append(scenes.evaluated_positions(ball))
    assert np.abs(shapes[0] - shapes[1]).max() > 0.01


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_a_squashed_ball_stays_on_the_ground(basis):
    ball = scenes.sphere()
    bpy.ops.isochor.add(resolution=(4, 4, 4), margin=0.0, basis="BERNSTEIN" if basis == "Bernstein" else "BSPLINE")
    modifier = ball.modifiers.active
    scenes.set_input(modifier, "Axes", (1.0, 1.0, 0.0))
    low = scenes.positions(ball.data)[:, 2].min()
    for squash in (0.7, 0.4, 1.5):
        scenes.set_input(modifier, "Squash", squash)
        bpy.context.view_layer.update()
        found = scenes.evaluated_positions(ball)
        assert found[:, 2].min() == close(low, abs=1e-5)
        assert np.ptp(found[:, 2]) == close(squash * np.ptp(scenes.positions(ball.data)[:, 2]), rel=1e-5)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) <= 1e-6


def test_the_rest_volume_does_not_depend_on_them():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    modifier = ball.modifiers.active
    kept = scenes.get_input(modifier, "Viewport Result")["isochor_rest_volume"]
    results = scenes.part("tool.results")
    for mode in ("Viewport", "Render"):
        results.forget_rest(scenes.get_input(modifier, f"{mode} Result"))
    for name, value in (("Squash", 0.3), ("Taper", 0.5), ("Twist", 1.0)):
        scenes.set_input(modifier, name, value)
    bpy.context.view_layer.update()
    assert scenes.get_input(modifier, "Viewport Result")["isochor_rest_volume"] == close(kept, rel=1e-9)


@pytest.mark.parametrize("shape", [(4, 4, 1), (1, 4, 4)])
def test_a_flat_lattice_twists_and_bends_too(shape):
    cage = Cage(shape=shape, sizes=(3.0, 3.0, 3.0))
    moved = cage.world(Axis="Z", Twist=1.0, Bend=1.0, Taper=0.3, Squash=0.5)
    assert np.isfinite(moved).all()
    assert scenes.report(cage.ball, cage.modifier).problems == ()


def test_no_finite_number_is_told_and_the_mesh_left_as_it_is():
    cage = Cage()
    for name in ("Twist", "Taper"):
        scenes.set_input(cage.modifier, name, math.nan)
    bpy.context.view_layer.update()
    problems = scenes.report(cage.ball, cage.modifier).problems
    assert problems == ("Taper, Twist: no finite number. Correct the driver or the keys, or type a value.",)
    assert np.abs(scenes.evaluated_positions(cage.ball) - scenes.positions(cage.ball.data)).max() == 0.0
    cage.framed("Z", Twist=0.0, Taper=0.0)
    assert scenes.report(cage.ball, cage.modifier).problems == ()


def test_a_squash_below_nothing_counts_as_one_to_nothing_and_even_that_keeps_the_volume():
    ball = scenes.sphere()
    modifier = scenes.volume_lattice(ball, scenes.lattice_object(4))
    shapes = []
    for squash in (0.0, -1.0):
        scenes.set_input(modifier, "Squash", squash)
        bpy.context.view_layer.update()
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) <= 1e-6
        shapes.append(scenes.report(ball, modifier).asked)
    assert np.array_equal(*shapes)
    assert np.ptp(shapes[0][..., 2]) < TINY


def test_a_lattice_that_only_moves_asks_for_the_same_in_every_frame():
    cage = Cage()
    scenes.set_input(cage.modifier, "Twist", 1.0)
    scenes.set_input(cage.modifier, "Space", "Object")
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    for obj in (cage.ball, cage.lattice):
        obj.parent = parent
    bpy.context.view_layer.update()
    asked = scenes.report(cage.ball, cage.modifier).asked
    for turn in (0.3, 1.7, -2.0):
        parent.rotation_euler = (turn, 0.2 * turn, -turn)
        parent.location.x += turn
        bpy.context.view_layer.update()
        assert scenes.report(cage.ball, cage.modifier).asked is asked
