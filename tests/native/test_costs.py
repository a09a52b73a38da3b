# SPDX-License-Identifier: GPL-3.0-or-later
"""Other costs (Remark 1): the distance that the surface moves, and bending."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from corrections import Correction, Solid
from oracle import Embedded, Spec
from refusals import refused

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-5": Spec((5, 5, 5), "bspline", 3, "uniform"),
    "clamped-mixed": Spec((5, 4, 6), "bspline", (2, 3, 1), "clamped"),
}
MESH = meshes.bumpy_ball(2, 0.2)
COSTS = ("points", "surface", "bending")
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", cases.METHODS)


def squashed(spec: Spec) -> np.ndarray:
    return spec.centre + (lattices.noisy(spec, 0.08) - spec.centre) * [1.05, 0.95, 0.5]


def travelled(spec: Spec, moved: np.ndarray) -> float:
    """Square root of the sum of the squared distances of the vertices."""
    return float(np.linalg.norm(Embedded.of(spec, *MESH).rows @ moved.reshape(-1, 3)))


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("cost", COSTS[1:])
@each_method
def test_volume_and_pins_are_exact_at_any_cost(cost, method, dtype):
    for seed in range(700, 760):
        case = cases.random_case(seed).in_dtype(dtype)
        if min(case.spec.shape) == 1 or not cases.solvable(case):
            continue
        result = case.bind().preserve(case.control, method=method, cost=cost, **case.arguments)
        try:
            cases.check_exact(case, result)
        except AssertionError as failure:
            raise AssertionError(f"case {seed}: {failure}") from failure


@each_spec
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_surface_moves_the_vertices_as_little_as_any_correction_of_that_axis_can(spec, axis):
    """Of all B δ with g · B δ = a the shortest is a P g / (g · P g), P the projection onto what the lattice can do."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    axes = np.eye(3)[axis]
    result = spec.build().bind(*MESH).preserve(control, method="sweep", cost="surface", axes=axes)
    points = embedded.deform(control)
    corners, gradient = points[MESH[1]], np.zeros(len(points))
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, axis] / 6
    np.add.at(gradient, MESH[1], areas[:, None])
    possible = embedded.rows @ np.linalg.lstsq(embedded.rows, gradient, rcond=1e-12)[0]
    change = oracle.volume(*MESH) - embedded.volume(control)
    moved = (embedded.rows @ (result.control - control).reshape(-1, 3))[:, axis]
    expected = change * possible / (gradient @ possible)
    assert np.linalg.norm(moved - expected) <= 1e-5 * np.linalg.norm(expected)


@each_spec
def test_surface_moves_the_surface_less_than_points_do(spec):
    control, binding = squashed(spec), spec.build().bind(*MESH)
    for method in ("sweep", "gradient", "nearest"):
        plain, surface = (binding.preserve(control, method=method, cost=c).control for c in ("points", "surface"))
        if method != "gradient":  # one step along another direction: the first order promises nothing
            assert travelled(spec, surface - control) < travelled(spec, plain - control)
        assert np.linalg.norm(surface - control) > np.linalg.norm(plain - control) or method != "nearest"


@each_spec
def test_nearest_by_the_surface_is_a_kkt_point_and_no_farther_than_the_others(spec):
    """P B δ = λ P g on each axis: what no multiplier explains of the surface's own motion is nothing."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    binding = spec.build().bind(*MESH)
    results = {m: binding.preserve(control, method=m, cost="surface").control for m in cases.METHODS}
    lengths = {m: travelled(spec, found - control) for m, found in results.items()}
    assert lengths["nearest"] <= min(lengths.values()) * (1 + 1e-7)
    moved = embedded.rows @ (results["nearest"] - control).reshape(-1, 3)
    basis = np.linalg.qr(embedded.rows)[0] if np.linalg.matrix_rank(embedded.rows) == embedded.rows.shape[1] else None
    basis = np.linalg.svd(embedded.rows, full_matrices=False)[0] if basis is None else basis
    asked = Correction(Solid.of(embedded), control)
    slope = asked.solid.gradients(results["nearest"])[0]
    possible = basis @ (basis.T @ np.linalg.lstsq(embedded.rows.T, slope, rcond=1e-12)[0])
    left = moved - possible * (np.sum(moved * possible) / np.sum(possible**2))
    assert np.linalg.norm(left) <= 1e-4 * np.linalg.norm(moved)


def not_affine(spec: Spec, moved: np.ndarray) -> float:
    """What an affine function of the rest points leaves of a displacement, as a fraction of it."""
    design = np.column_stack([spec.rest.reshape(-1, 3), np.ones(np.prod(spec.shape))])
    moved = moved.reshape(-1, 3)
    left = moved - design @ np.linalg.lstsq(design, moved, rcond=None)[0]
    return float(np.linalg.norm(left) / np.linalg.norm(moved))


@each_spec
@each_method
def test_bending_corrects_by_an_affine_map_where_that_can_do_it(spec, method):
    """Affine maps bend nothing, so nothing else is needed for one volume; equal distances would bend."""
    control, binding = squashed(spec), spec.build().bind(*MESH)
    for axes in ((1, 1, 1), (0, 0, 1)):
        bending, points = (
            binding.preserve(control, method=method, axes=axes, cost=c).control - control for c in ("bending", "points")
        )
        assert not_affine(spec, bending) <= 1e-3
        assert not_affine(spec, points) > 1e-2


@each_spec
def test_bending_with_three_pins_is_the_affine_map_through_them(spec):
    """Along one axis three pins and the volume are four conditions: just as many as an affine function has freedom."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    chosen = [3, 77, 120]
    moves = np.random.default_rng(1).uniform(-0.05, 0.05, (3, 3)) * [0, 0, 1]
    asked = Correction(Solid.of(embedded), control, pin_rows=embedded.rows[chosen], pin_moves=moves)
    design = np.column_stack([spec.rest.reshape(-1, 3), np.ones(np.prod(spec.shape))])
    slope = asked.solid.gradients(control)[0][:, 2]
    change = oracle.volume(*MESH) - embedded.volume(control)
    conditions = np.concatenate([embedded.rows[chosen], slope[None]]) @ design
    expected = design @ np.linalg.solve(conditions, np.append(moves[:, 2], change))
    pins = (chosen, embedded.deform(control)[chosen] + moves)
    result = spec.build().bind(*MESH).preserve(control, method="sweep", axes=(0, 0, 1), cost="bending", pins=pins)
    moved = (result.control - control).reshape(-1, 3)
    assert np.linalg.norm(moved[:, 2] - expected) <= 1e-3 * np.linalg.norm(expected)
    assert np.abs(moved[:, :2]).max() <= 1e-9


@each_method
def test_bending_is_smoother_than_points_where_part_is_frozen(method):
    spec = Spec((7, 7, 7), "bspline", 3, "uniform")
    control, weights = squashed(spec), np.ones(spec.shape)
    weights[:3] = np.inf
    binding = spec.build().bind(*MESH)
    rough = {}
    for cost in ("points", "bending"):
        result = binding.preserve(control, method=method, weights=weights, cost=cost)
        np.testing.assert_array_equal(result.control[:3], control[:3])
        moved = result.control - control
        second = [np.diff(moved, 2, axis=axis).ravel() for axis in range(3)]
        rough[cost] = np.linalg.norm(np.concatenate(second)) / np.linalg.norm(moved)
    assert rough["bending"] < 0.7 * rough["points"]


@pytest.mark.parametrize("cost", COSTS[1:])
def test_a_point_that_costs_more_moves_less(cost):
    spec = SPECS["uniform-5"]
    control, binding = squashed(spec), spec.build().bind(*MESH)
    weights = np.ones(spec.shape)
    weights[:2] = 100.0
    plain, weighted = (
        binding.preserve(control, method="nearest", cost=cost, weights=w).control - control for w in (None, weights)
    )
    assert np.linalg.norm(weighted[:2]) < 0.5 * np.linalg.norm(plain[:2])


@pytest.mark.parametrize("cost", COSTS[1:])
def test_costs_stay_what_they_are_after_an_update(cost):
    spec = SPECS["uniform-5"]
    moved = MESH[0] * [0.9, 0.95, 1.0]
    binding, fresh = spec.build().bind(*MESH), spec.build().bind(moved, MESH[1])
    binding.preserve(squashed(spec), cost=cost)
    binding.update(moved)
    found, expected = (b.preserve(squashed(spec), cost=cost).control for b in (binding, fresh))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("cost", ["length", "", None, 1], ids=repr)
def test_unknown_cost_lists_the_choices(cost):
    with refused(isochor.Error, "cost", "points", "surface", "bending"):
        Spec().build().bind(*MESH).preserve(Spec().rest, cost=cost)
