# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights that keep the correction near points, or where the volume went."""

from __future__ import annotations

import isochor
import numpy as np
import pytest
from determinants import determinants
from isochor import LatticeError
from lattices import OBLIQUE, SOLID, noisy
from meshes import bumpy_ball
from oracle import Spec
from refusals import refused

BARS = {
    "clamped": Spec((12, 4, 4), "bspline", 3, "clamped"),
    "uniform": Spec((14, 6, 6), "bspline", 3, "uniform"),
    "bernstein": Spec((16, 4, 4)),
}


def test_falloff_is_the_exponential_of_the_distance_to_the_nearest_point():
    lattice = isochor.Lattice(shape=(4, 5, 6), edges=OBLIQUE)
    points = np.array([[0.2, 0.3, 1.5], [-1, 0, 0]])
    for control in (None, noisy(Spec((4, 5, 6), edges=OBLIQUE), 0.5, 1)):
        places = lattice.rest if control is None else control
        nearest = np.linalg.norm(places[..., None, :] - points, axis=-1).min(axis=-1)
        weights = lattice.falloff(points, 0.4, control)
        assert weights.shape == (4, 5, 6)
        assert weights.dtype == np.float64
        np.testing.assert_allclose(weights, np.exp(nearest / 0.4), rtol=1e-13)


def test_a_correction_with_falloff_stays_near_the_point():
    vertices, triangles = bumpy_ball()
    lattice = isochor.Lattice.around(vertices, shape=(10, 10, 10), basis="bspline", margin=0.1)
    binding = lattice.bind(vertices, triangles)
    control = lattice.rest * [1, 1, 0.7]
    weights = lattice.falloff([vertices.max(axis=0)], 0.05)
    moved = {}
    for name, given in (("none", None), ("near", weights)):
        result = binding.preserve(control, weights=given)
        assert result.error < 1e-12
        moved[name] = np.linalg.norm(result.vertices - binding.deform(control), axis=1)
    far = np.linalg.norm(vertices - vertices.max(axis=0), axis=1) > 0.8
    assert moved["none"][far].max() > 0.02
    assert moved["near"][far].max() < 0.02 * moved["near"].max()


def test_a_falloff_much_shorter_than_the_distance_still_corrects():
    vertices, triangles = bumpy_ball()
    lattice = isochor.Lattice.around(vertices, shape=(4, 4, 4))
    weights = lattice.falloff([[30.0, 0, 0]], 0.01)
    assert np.isfinite(weights.min())
    result = lattice.bind(vertices, triangles).preserve(lattice.rest * [1, 1, 0.9], weights=weights)
    assert result.error < 1e-12


@pytest.mark.parametrize("name", SOLID)
def test_a_change_that_is_the_same_everywhere_weighs_all_alike(name):
    spec = SOLID[name]
    lattice = spec.build()
    about = spec.rest - spec.centre
    for scale in (np.diag([1, 1, 0.4]), np.diag([2.0, 1, 1]), np.eye(3)):
        np.testing.assert_allclose(lattice.loss_weights(about @ scale), 1, rtol=1e-6)
    np.testing.assert_array_equal(lattice.loss_weights(about * 0.5, rest=about * 0.5), 1)


@pytest.mark.parametrize("name", BARS)
def test_weights_are_the_change_of_volume_averaged_over_each_basis_function(name):
    """Against a dense midpoint rule on det J of another make: the library samples d + 1 places a cell."""
    spec = BARS[name]
    control = bar_squashed_at_one_end(spec)
    places = (np.stack(np.meshgrid(*(np.arange(n) for n in (72, 16, 16)), indexing="ij"), -1) + 0.5) / (72, 16, 16)
    places = places.reshape(-1, 3)
    basis = spec.matrix(places)
    change = np.abs((determinants(spec, control, places) - 1) @ basis / basis.sum(axis=0)).reshape(spec.shape)
    for floor in (0.01, 0.3, 1.0):
        expected = 1 / (floor + (1 - floor) * change / change.max())
        found = spec.build().loss_weights(control, floor=floor)
        np.testing.assert_allclose(1 / found, 1 / expected, atol=0.03)
        assert found.min() == pytest.approx(1, rel=1e-15, abs=0)
        assert found.max() <= 1 / floor * (1 + 1e-15)


@pytest.mark.parametrize("name", BARS)
def test_the_correction_of_a_bar_squashed_at_one_end_stays_there(name):
    spec = BARS[name]
    vertices, triangles = bumpy_ball(4)
    lattice = spec.build()
    binding = lattice.bind(vertices, triangles)
    control = bar_squashed_at_one_end(spec)
    plain = binding.deform(control)
    squashed, other = vertices[:, 0] < 0.3, vertices[:, 0] > 0.7
    part = {}
    for weighed in (False, True):
        result = binding.preserve(control, weights=lattice.loss_weights(control) if weighed else None)
        assert result.error < 1e-12
        moved = np.linalg.norm(result.vertices - plain, axis=1)
        part[weighed] = moved[other].max() / moved[squashed].max()
    assert part[False] > 0.2, part
    # Bernstein polynomials of degree 15 reach everywhere, if weakly.
    assert part[True] < (0.2 if name == "bernstein" else 0.1), part
    assert part[True] < part[False] / 4, part


def bar_squashed_at_one_end(spec: Spec):
    """Control points of the unit cube, thinner towards s = 0, from the middle on."""
    control = spec.rest.copy()
    thin = 1 - 0.7 * np.clip(1 - 2 * spec.rest[..., 0], 0, 1)
    control[..., 2] = 0.5 + (control[..., 2] - 0.5) * thin
    return control


def test_wrong_arguments():
    lattice = isochor.Lattice(shape=(4, 4, 4))
    broken = lattice.rest.copy()
    broken[1, 2, 3, 0] = np.nan
    for points in (np.zeros((0, 3)), [[0, 0, np.nan]], [1, 2, 3], "points"):
        with refused(LatticeError, "points"):
            lattice.falloff(points, 1.0)
    for distance in (0, -1, np.nan, np.inf, "far"):
        with refused(LatticeError, "distance"):
            lattice.falloff([[0, 0, 0]], distance)
    for control in (broken, lattice.rest[1:]):
        for call in (lambda c: lattice.falloff([[0, 0, 0]], 1, c), lattice.loss_weights):
            with refused(LatticeError, "control"):
                call(control)
        with refused(LatticeError, "rest"):
            lattice.loss_weights(lattice.rest, rest=control)
    for floor in (0, -1, 1.1, np.nan, "low"):
        with refused(LatticeError, "floor"):
            lattice.loss_weights(lattice.rest, floor=floor)
