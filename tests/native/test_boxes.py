# SPDX-License-Identifier: GPL-3.0-or-later
"""Boxes that stand any way in space: given by centre, axes and half-widths (Hoff), and found around points."""

import isochor
import lattices
import meshes
import numpy as np
import pytest
from isochor import Lattice, LatticeError
from refusals import refused

CORNERS = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3)
TURNS = {"none": np.eye(3), "some": lattices.rotation(), "much": lattices.rotation((-2, 0.3, 1), 2.4)}


def held(points, centre, axes, half_widths, room=1e-12):
    return bool(np.all(np.abs((points - centre) @ axes.T) <= half_widths + room))


@pytest.mark.parametrize("turn", TURNS.values(), ids=TURNS)
@pytest.mark.parametrize("size", [(4, 1, 0.5), (3, 1, 1), (2, 2, 2), (2, 1, 0), (500, 2, 1), (1, 1, 1e-3)])
def test_a_box_is_found_however_it_is_turned(turn, size):
    inside = np.random.default_rng(2).uniform(0.2, 0.4, (50, 3))
    points = np.concatenate([CORNERS, inside]) * size @ turn.T + (10, -3, 7)
    centre, axes, half_widths = isochor.oriented_box(points)
    np.testing.assert_allclose(sorted(2 * half_widths), sorted(size), rtol=0, atol=1e-11 * max(size))
    np.testing.assert_allclose(centre, (10, -3, 7), rtol=0, atol=1e-11 * max(size))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(axes) > 0
    assert held(points, centre, axes, half_widths, 1e-11 * max(size))


def test_axes_are_those_that_are_wanted_where_the_box_allows():
    turn = lattices.rotation()
    points = CORNERS * (4, 2, 1) @ turn.T
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        like = turn.T[order]
        _, axes, half_widths = isochor.oriented_box(points, like=like)
        np.testing.assert_allclose(axes, like, rtol=0, atol=1e-12)
        np.testing.assert_allclose(half_widths, np.array([2, 1, 0.5])[order], rtol=0, atol=1e-12)
    cube = CORNERS @ turn.T
    assert np.allclose(isochor.oriented_box(cube, like=turn.T)[1], turn.T, rtol=0, atol=1e-12)


def test_a_large_cloud_is_held_and_gets_a_smaller_box():
    random = np.random.default_rng(7)
    points = random.normal(size=(30_000, 3)) @ [(1.0, 0.8, 0.1), (0.0, 0.6, 0.4), (0.0, 0.0, 0.3)]
    centre, axes, half_widths = isochor.oriented_box(points)
    assert held(points, centre, axes, half_widths)
    assert np.prod(2 * half_widths) < 0.8 * np.prod(np.ptp(points, axis=0))


def test_the_same_box_at_every_call():
    points = np.random.default_rng(9).normal(size=(5000, 3))
    first, second = isochor.oriented_box(points), isochor.oriented_box(points)
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


@pytest.mark.parametrize("margin", [0.0, 0.2])
def test_a_lattice_around_an_oriented_box_holds_the_mesh(margin):
    vertices, triangles = meshes.box(4)
    vertices = vertices * (3, 1, 0.4) @ lattices.rotation().T + (5, 6, 7)
    lattice = Lattice.around(vertices, (4, 4, 4), margin=margin, fit="oriented")
    parameters = lattice.parameters(vertices)
    room = margin / (1 + 2 * margin)
    np.testing.assert_allclose(parameters.min(axis=0), room, rtol=0, atol=1e-12)
    np.testing.assert_allclose(parameters.max(axis=0), 1 - room, rtol=0, atol=1e-12)
    binding = lattice.bind(vertices, triangles, device="cpu")
    assert binding.outside_count == 0
    assert binding.preserve(lattice.rest * (1, 1, 0.5)).error < 1e-12


@pytest.mark.parametrize(
    "points",
    [[(1, 2, 3)], [(0, 0, 0), (1, 2, 2)], [(0, 0, 0), (1, 1, 0), (2, 0, 1)], np.outer(np.arange(9), (1, 2, 3))],
    ids=["one", "two", "three", "straight"],
)
def test_flat_straight_and_single_points_get_a_lattice(points):
    centre, axes, half_widths = isochor.oriented_box(points)
    assert held(np.array(points, dtype=float), centre, axes, half_widths)
    assert half_widths.min() < 1e-14
    lattice = Lattice.around(points, fit="oriented")
    inside = lattice.parameters(points)
    assert inside.min() > -1e-12
    assert inside.max() < 1 + 1e-12


def test_hoffs_box():
    turn, half_widths, centre = lattices.rotation(), np.array([2.0, 0.5, 1.0]), np.array([3.0, -1.0, 2.0])
    lattice = Lattice.box(centre, turn.T * [[3], [0.1], [7]], half_widths, (3, 4, 5), "bspline", degree=2)
    assert lattice.shape == (3, 4, 5)
    np.testing.assert_allclose(lattice.origin, centre - half_widths @ turn.T, rtol=0, atol=1e-14)
    np.testing.assert_allclose(lattice.edges, 2 * half_widths[:, None] * turn.T, rtol=0, atol=1e-14)
    points = np.random.default_rng(1).normal(size=(20, 3))
    hoff = (points - centre) @ turn / half_widths  # from -1 to 1 between the faces
    np.testing.assert_allclose(2 * lattice.parameters(points) - 1, hoff, rtol=0, atol=1e-13)
    aligned = Lattice.box((0, 0, 0), None, (1, 1, 1))
    assert np.array_equal(aligned.edges, 2 * np.eye(3))


def test_what_is_no_box():
    with refused(LatticeError, "half_widths", "axis t", "positive"):
        Lattice.box((0, 0, 0), None, (1, 0, 1))
    with refused(LatticeError, "axes", "independent"):
        Lattice.box((0, 0, 0), [(1, 0, 0), (2, 0, 0), (0, 0, 1)], (1, 1, 1))
    with refused(LatticeError, "centre"):
        Lattice.box((0, 0), None, (1, 1, 1))
    with refused(LatticeError, "fit", "axes", "oriented"):
        Lattice.around(CORNERS, fit="pca")
    with refused(LatticeError, "points", "none"):
        isochor.oriented_box(np.zeros((0, 3)))
    with refused(LatticeError, "points", "NaN"):
        isochor.oriented_box([(0, 0, float("nan"))])
    with refused(LatticeError, "like", "independent"):
        isochor.oriented_box(CORNERS, like=np.zeros((3, 3)))
