# SPDX-License-Identifier: GPL-3.0-or-later
"""The oracle against facts that need no library: a wrong yardstick would pass or fail everything else."""

from fractions import Fraction
from itertools import pairwise

import lattices
import meshes
import numpy as np
import oracle
import pytest

MESHES = {
    "sphere": meshes.icosphere(3),
    "bumpy": meshes.bumpy_ball(),
    "torus": meshes.torus(),
    "box": meshes.box(),
    "tetrahedron": meshes.tetrahedron(),
    "islands": meshes.two_islands(),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_meshes_are_closed_and_every_edge_is_used_once_each_way(mesh):
    half_edges = np.concatenate([mesh[1][:, [0, 1]], mesh[1][:, [1, 2]], mesh[1][:, [2, 0]]]).tolist()
    assert len(set(map(tuple, half_edges))) == len(half_edges)
    assert {(b, a) for a, b in half_edges} == set(map(tuple, half_edges))
    assert oracle.volume(*mesh) > 0


def test_volumes_known_in_closed_form():
    assert oracle.volume(*meshes.tetrahedron(0.5)) == pytest.approx(0.5**3 / 6, rel=1e-15)
    assert oracle.volume(*meshes.box()) == pytest.approx(0.8**3, rel=1e-15)
    assert oracle.volume(*meshes.icosphere(5)) == pytest.approx(4 / 3 * np.pi * 0.45**3, rel=3e-3)
    assert oracle.volume(*meshes.inside_out(meshes.box())) == -oracle.volume(*meshes.box())


@pytest.mark.parametrize("spec", lattices.SOLID.values(), ids=lattices.SOLID)
def test_basis_is_a_partition_of_unity_with_linear_precision(spec):
    points = lattices.points_inside(spec)
    matrix = spec.matrix(np.clip(spec.parameters(points), 0, 1))
    assert matrix.min() >= 0
    np.testing.assert_allclose(matrix.sum(axis=1), 1, rtol=0, atol=1e-13)
    scale = np.abs(points).max()
    np.testing.assert_allclose(matrix @ spec.rest.reshape(-1, 3), points, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("degree", [1, 3, 8, 20])
def test_bernstein_against_exact_fractions(degree):
    for t in (Fraction(0), Fraction(1, 3), Fraction(7, 8), Fraction(1)):
        exact = [float(_exact_bernstein(degree, i, t)) for i in range(degree + 1)]
        np.testing.assert_allclose(oracle.bernstein(degree, np.array([float(t)]))[0], exact, rtol=1e-13, atol=0)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_clamped_bspline_of_one_span_is_bernstein(degree):
    spec = oracle.Spec((degree + 1,) * 3, "bspline", degree, "clamped")
    t = np.linspace(0, 1, 33)
    np.testing.assert_allclose(spec.axis_weights(0, t), oracle.bernstein(degree, t), rtol=0, atol=1e-15)


def test_uniform_cubic_at_a_knot_is_one_sixth_four_sixths_one_sixth():
    weights = oracle.Spec((6, 6, 6), "bspline", 3, "uniform").axis_weights(0, np.array([0.0, 1 / 3, 1.0]))
    np.testing.assert_allclose(weights[0, :4], np.array([1, 4, 1, 0]) / 6, atol=1e-15)
    np.testing.assert_allclose(weights[1, 1:5], np.array([1, 4, 1, 0]) / 6, atol=1e-14)
    np.testing.assert_allclose(weights[2, 2:], np.array([0, 1, 4, 1]) / 6, atol=1e-15)


def test_coefficients_predict_the_volume_of_any_move_along_one_direction():
    spec = oracle.Spec((5, 4, 6), "bspline", 3, "uniform")
    embedded = oracle.Embedded.of(spec, *meshes.bumpy_ball())
    control, random = lattices.noisy(spec), np.random.default_rng(2)
    for direction in [*np.eye(3), random.normal(size=3)]:
        step = random.normal(size=spec.shape)
        predicted = embedded.volume(control) + embedded.coefficients(control, direction) @ step.ravel()
        assert embedded.volume(control + step[..., None] * direction) == pytest.approx(predicted, rel=1e-12)


def test_corrections_reach_the_target():
    embedded = oracle.Embedded.of(oracle.Spec(), *meshes.bumpy_ball())
    control, target = lattices.deformed(oracle.Spec(), "squash", 0.7), embedded.volume(oracle.Spec().rest)
    for method in (embedded.sweep, embedded.balanced):
        assert embedded.volume(method(control, (1, 2, 0), target)) == pytest.approx(target, rel=1e-13)


@pytest.mark.parametrize(("kind", "ratio"), [("squash", 0.15), ("twist", 0.34), ("inflate", 4.0), ("dent", 0.6)])
def test_planned_losses_are_met(kind, ratio):
    embedded = oracle.Embedded.of(oracle.Spec(), *meshes.icosphere(3))
    control = lattices.to_ratio(embedded, kind, ratio)
    assert embedded.volume(control) / embedded.volume(oracle.Spec().rest) == pytest.approx(ratio, abs=1e-6)


def _exact_bernstein(degree: int, i: int, t: Fraction) -> Fraction:
    """By the recursion of de Casteljau, in rationals."""
    if not 0 <= i <= degree:
        return Fraction(0)
    if degree == 0:
        return Fraction(1)
    values = [Fraction(int(j == i)) for j in range(degree + 1)]
    while len(values) > 1:
        values = [(1 - t) * a + t * b for a, b in pairwise(values)]
    return values[0]
