# SPDX-License-Identifier: GPL-3.0-or-later
"""Oriented boxes: by centre, axes and half-widths, and fitted to points."""

import itertools

import isochor
import lattices
import meshes
import numpy as np
import pytest
from isochor import LatticeError
from oracle import Array
from refusals import refused

TURNS = [lattices.rotation(axis, angle) for axis, angle in (((1, 2, 3), 0.7), ((0, 0, 1), 0.3), ((-2, 1, 0.5), 2.5))]
HALVES = np.array([3.0, 1.0, 0.25])
CENTRE = np.array([5.0, -7.0, 11.0])


def contains(box, points: Array, slack: float = 1e-9) -> None:
    centre, axes, halves = box
    assert (centre.shape, axes.shape, halves.shape) == ((3,), (3, 3), (3,))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-12)
    assert np.linalg.det(axes) > 0
    local = (points - centre) @ axes.T
    rounding = 8 * np.finfo(np.float64).eps * np.abs(points).max()
    assert np.all(np.abs(local) <= halves + slack * halves.max() + rounding)
    spread = np.maximum(local.max(axis=0), -local.min(axis=0))
    np.testing.assert_allclose(spread, halves, rtol=0, atol=1e-9 * halves.max() + rounding)


def clouds():
    random = np.random.default_rng(1)
    yield from (random.normal(size=(n, 3)) * random.uniform(0.1, 10, 3) @ TURNS[n % 3] for n in (4, 5, 8, 50, 2000))
    yield meshes.bumpy_ball(3)[0]
    yield meshes.torus()[0] @ TURNS[0]
    yield random.integers(0, 3, (200, 3)).astype(float) @ TURNS[1]  # many points in common planes, many repeated
    yield 1e-7 * random.random((30, 3)) + 1
    yield 1e8 * random.random((30, 3))


@pytest.mark.parametrize("number", range(10))
def test_every_point_is_inside_and_every_side_touches(number):
    points = list(clouds())[number]
    contains(isochor.oriented_box(points), points)


def corners_and_inner() -> Array:
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * HALVES
    return np.concatenate([corners, np.random.default_rng(2).uniform(-1, 1, (400, 3)) * HALVES])


@pytest.mark.parametrize("turn", TURNS, ids=["oblique", "about-z", "steep"])
def test_a_turned_box_is_found_exactly(turn):
    """Centre, half-widths, and the axes but for their order and signs."""
    points = CENTRE + corners_and_inner() @ turn
    centre, axes, halves = isochor.oriented_box(points)
    contains((centre, axes, halves), points)
    np.testing.assert_allclose(centre, CENTRE, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.sort(halves), np.sort(HALVES), rtol=1e-9)
    match = np.abs(axes @ turn.T)
    np.testing.assert_allclose(np.sort(match, axis=1), [[0, 0, 1]] * 3, rtol=0, atol=1e-8)


def test_a_turned_box_of_corners_alone_and_a_grid_of_it():
    """Eight points; and evenly many points, which pull no principal axis the right way."""
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 6)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * [2, 2, 2]
    for local, volume in (
        (np.array(list(itertools.product((-1, 1), repeat=3))) * HALVES, 8 * HALVES.prod()),
        (grid, 64),
    ):
        _, _, halves = isochor.oriented_box(local @ TURNS[0] + CENTRE)
        assert 8 * halves.prod() == pytest.approx(volume, rel=1e-8)


def test_points_all_on_one_side_do_not_turn_it():
    """A box with a thousand points crowded in one corner: principal axes would turn, the box does not."""
    crowd = HALVES - 0.2 * np.random.default_rng(3).random((1000, 3))
    points = np.concatenate([corners_and_inner()[:8], crowd]) @ TURNS[0]
    halves = isochor.oriented_box(points)[2]
    assert 8 * halves.prod() == pytest.approx(8 * HALVES.prod(), rel=1e-6)


@pytest.mark.parametrize("number", range(10))
def test_never_larger_than_the_upright_box_or_the_principal_one(number):
    points = list(clouds())[number]
    volume = 8 * isochor.oriented_box(points)[2].prod()
    upright = np.ptp(points, axis=0).prod()
    principal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    assert volume <= min(upright, np.ptp(points @ principal.T, axis=0).prod()) * (1 + 1e-6)


def test_flat_and_thin_and_single_points_have_boxes_too():
    random = np.random.default_rng(4)
    flat = np.pad(random.random((40, 2)) * [3, 1], ((0, 0), (0, 1))) @ TURNS[0]
    line = random.random((20, 1)) * TURNS[1][:1]
    for points, thin in ((flat, 1), (line, 2), (np.ones((1, 3)), 3), (np.ones((5, 3)), 3)):
        centre, axes, halves = isochor.oriented_box(points)
        assert np.all(np.isfinite(centre))
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-12)
        local = np.abs((points - centre) @ axes.T)
        assert np.all(local <= halves + 1e-9)
        assert np.sum(halves < 1e-9) == thin


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("basis", ["bernstein", "bspline"])
def test_a_lattice_fitted_so_holds_every_point(basis, dtype):
    points = (CENTRE + corners_and_inner() @ TURNS[0]).astype(dtype)
    lattice = isochor.Lattice.around(points, shape=(5, 4, 6), basis=basis, fit="oriented")
    parameters = lattice.parameters(points)
    assert parameters.min() >= -1e-9
    assert parameters.max() <= 1 + 1e-9
    moved = lattice.bind(points, outside="keep").deform(lattice.rest + [1, 2, 3])
    np.testing.assert_allclose(
        moved, points + np.array([1, 2, 3], dtype), rtol=0, atol=1e-4 if dtype == np.float32 else 1e-11
    )
    volume = abs(np.linalg.det(lattice.edges))
    assert volume == pytest.approx(8 * HALVES.prod(), rel=1e-5)
    assert volume < 0.7 * abs(np.linalg.det(isochor.Lattice.around(points, shape=(5, 4, 6), fit="axes").edges))
    assert np.linalg.det(lattice.edges) > 0


def test_upright_is_the_default_and_margins_widen_both():
    points = meshes.bumpy_ball(2)[0]
    plain, axes = (isochor.Lattice.around(points, shape=(4, 4, 4), **o) for o in ({}, {"fit": "axes"}))
    np.testing.assert_array_equal(plain.rest, axes.rest)
    wide = isochor.Lattice.around(points, shape=(4, 4, 4), fit="oriented", margin=0.1)
    assert wide.parameters(points).min() > 0.01
    assert wide.parameters(points).max() < 0.99


def test_a_flat_cloud_gets_an_oriented_lattice_that_can_move_it():
    plane = np.pad(np.random.default_rng(0).random((30, 2)) * [5, 2], ((0, 0), (0, 1))) @ TURNS[0]
    lattice = isochor.Lattice.around(plane, shape=(4, 4, 4), fit="oriented")
    lifted = lattice.bind(plane).deform(lattice.rest + TURNS[0][2])
    np.testing.assert_allclose(lifted, plane + TURNS[0][2], rtol=0, atol=1e-12)


@pytest.mark.parametrize("basis", ["bernstein", "bspline", "blender"])
def test_hoffs_box_has_any_basis_and_weights(basis):
    lattice = isochor.Lattice.box(CENTRE, TURNS[0], HALVES, shape=(4, 5, 6), basis=basis)
    np.testing.assert_allclose(lattice.origin, CENTRE - HALVES @ TURNS[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(lattice.edges, 2 * HALVES[:, None] * TURNS[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(lattice.parameters([CENTRE]), [[0.5, 0.5, 0.5]], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("centre", (0, 0)),
        ("centre", (0, 0, np.nan)),
        ("axes", np.zeros((3, 3))),
        ("axes", [[1, 0, 0], [2, 0, 0], [0, 0, 1]]),
        ("axes", np.eye(2)),
        ("axes", np.full((3, 3), np.inf)),
        ("half_widths", (1, 1)),
        ("half_widths", (1, 0, 1)),
        ("half_widths", (1, -1, 1)),
        ("half_widths", (1, np.nan, 1)),
    ],
)
def test_what_is_no_box_is_refused(name, value):
    given = {"centre": (0, 0, 0), "axes": np.eye(3), "half_widths": (1, 1, 1)} | {name: value}
    word = {"centre": "centre", "axes": ("axes", "axis"), "half_widths": ("half", "width")}[name]
    with refused(LatticeError, word):
        isochor.Lattice.box(**given, shape=(4, 4, 4))


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.ones((4, 2)), [[0, 0, np.nan]], "points", None], ids=repr)
def test_what_has_no_box_is_refused(points):
    with refused(isochor.Error, ("point", "vert")):
        isochor.oriented_box(points)
    with refused(isochor.Error, ("point", "vert")):
        isochor.Lattice.around(points, shape=(4, 4, 4), fit="oriented")


@pytest.mark.parametrize("fit", ["", "pca", None, 3, b"axes"], ids=repr)
def test_unknown_fits_list_the_choices(fit):
    with refused(LatticeError, "fit", "axes", "oriented"):
        isochor.Lattice.around(np.random.default_rng(0).random((9, 3)), shape=(4, 4, 4), fit=fit)
