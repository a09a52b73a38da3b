# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights made for the correction: a falloff from points (figure 7), and where the volume was lost."""

import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Spec
from refusals import refused

SPECS = {
    "bernstein-5": Spec((5, 5, 5)),
    "uniform-7": Spec((7, 6, 5), "bspline", 3, "uniform"),
    "oblique": lattices.FRAMES["oblique"],
}
MESH = meshes.bumpy_ball(2, 0.2)
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)


@each_spec
@pytest.mark.parametrize("moved", [False, True])
def test_falloff_is_an_exponential_of_the_distance_to_the_nearest_point(spec, moved):
    points = np.array([[0.2, 0.3, 0.4], [0.9, 0.8, 1.2]])
    control = lattices.noisy(spec, 0.2) if moved else None
    weights = spec.build().falloff(points, 0.3, control=control)
    places = spec.rest if control is None else control
    nearest = np.linalg.norm(places[..., None, :] - points, axis=-1).min(axis=-1)
    assert weights.shape == spec.shape
    np.testing.assert_allclose(weights, np.exp(nearest / 0.3), rtol=1e-12)


def test_falloff_keeps_the_correction_near_the_points():
    spec = SPECS["uniform-7"]
    lattice, control = spec.build(), lattices.deformed(spec, "squash", 0.2)
    binding = lattice.bind(*MESH)
    top = MESH[0][np.argmax(MESH[0][:, 0])]
    results = [binding.preserve(control, weights=w).control - control for w in (None, lattice.falloff([top], 0.1))]
    reach = np.linalg.norm(spec.rest - top, axis=-1)
    far = [np.linalg.norm(moved[reach > 0.6]) / np.linalg.norm(moved) for moved in results]
    assert far[1] < 0.2 * far[0]


@pytest.mark.parametrize("distance", [0.0, -1.0, np.nan])
def test_a_falloff_over_no_distance_is_refused(distance):
    with refused(isochor.Error, "distance"):
        Spec().build().falloff([[0.5, 0.5, 0.5]], distance)


@pytest.mark.parametrize("points", [[[np.nan, 0, 0]], [[0.0, 0.0]], np.zeros((0, 3)), "here"], ids=str)
def test_a_falloff_from_points_that_are_none_is_refused(points):
    with refused(isochor.Error, "point"):
        Spec().build().falloff(points, 0.1)


def shrunk_on_one_side(spec: Spec) -> np.ndarray:
    """The half x > ½ is squashed in z by up to 60 %; the other is as it was."""
    control = spec.rest.copy()
    control[..., 2] = 0.5 + (control[..., 2] - 0.5) * (1 - 0.6 * np.clip(2 * spec.rest[..., 0] - 1, 0, 1))
    return control


@pytest.mark.parametrize("name", ["bernstein-5", "uniform-7"])
def test_the_correction_goes_where_the_loss_is(name):
    spec = SPECS[name]
    lattice, control = spec.build(), shrunk_on_one_side(spec)
    weights = lattice.loss_weights(control)
    assert weights.shape == spec.shape
    assert np.all(weights > 0)
    assert np.all(np.isfinite(weights))
    lost, kept = spec.rest[..., 0] > 0.7, spec.rest[..., 0] < 0.3
    assert weights[lost].mean() < 0.5 * weights[kept].mean()
    binding = lattice.bind(*MESH)
    plain, local = (binding.preserve(control, weights=w) for w in (None, weights))
    assert oracle.volume(local.vertices, MESH[1]) == pytest.approx(oracle.volume(*MESH), rel=1e-12)
    share = [np.linalg.norm((r.control - control)[kept]) / np.linalg.norm(r.control - control) for r in (plain, local)]
    assert share[1] < 0.7 * share[0]


@each_spec
def test_without_any_loss_all_weights_are_equal(spec):
    for control in (spec.rest, spec.rest + [3.0, -2.0, 1.0], spec.rest @ lattices.rotation().T):
        weights = spec.build().loss_weights(control)
        np.testing.assert_allclose(weights / weights.max(), 1, rtol=1e-6)


@pytest.mark.parametrize("floor", [1e-3, 0.1])
def test_the_floor_is_the_smallest_ratio_of_the_weights(floor):
    weights = SPECS["uniform-7"].build().loss_weights(shrunk_on_one_side(SPECS["uniform-7"]), floor=floor)
    assert weights.min() / weights.max() >= floor * (1 - 1e-9)
    assert weights.min() / weights.max() < 0.6


def test_loss_is_counted_from_the_rest_that_is_given():
    spec = SPECS["uniform-7"]
    control = shrunk_on_one_side(spec)
    weights = spec.build().loss_weights(control, rest=control)
    np.testing.assert_allclose(weights / weights.max(), 1, rtol=1e-6)
