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
    for seed in range(700, 730):
        case = cases.random_case(seed).in_dtype(dtype)
        if min(case.spec.shape) == 1 or not cases.solvable(case):
            continue
        case.options["amount"] = 1.0  # the volume with the pins alone depends on the cost
        result = case.bind().preserve(case.control, method=method, cost=cost, **case.arguments)
        try:
            cases.check_exact(case, result)
        except AssertionError as failure:
            raise AssertionError(f"case {seed}: {failure}") from failure


def surface_cost(rows: np.ndarray) -> np.ndarray:
    """BᵀB, and a thousandth of its mean diagonal, which holds points that the mesh hardly feels."""
    cost = rows.T @ rows
    return cost + 1e-3 * np.trace(cost) / len(cost) * np.eye(len(cost))


@each_spec
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_surface_is_the_closed_form_and_not_far_from_the_shortest_way_of_the_vertices(spec, axis):
    """Of all B δ with g · B δ = a the shortest is a P g / (g · P g), P the projection onto what the lattice can do."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    slope = Solid.of(embedded).gradients(control)[0][:, axis]
    change = oracle.volume(*MESH) - embedded.volume(control)
    result = spec.build().bind(*MESH).preserve(control, method="sweep", cost="surface", axes=np.eye(3)[axis])
    moved = (result.control - control).reshape(-1, 3)[:, axis]
    expected = np.linalg.solve(surface_cost(embedded.rows), slope)
    expected *= change / (slope @ expected)
    assert np.linalg.norm(moved - expected) <= 1e-7 * np.linalg.norm(expected)
    shortest = abs(change) / np.linalg.norm(np.linalg.lstsq(embedded.rows.T, slope, rcond=1e-12)[0])
    assert np.linalg.norm(embedded.rows @ moved) <= 1.6 * shortest


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
    """Q δ = λ c on all axes, with Q of the closed form and one λ."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    binding = spec.build().bind(*MESH)
    results = {m: binding.preserve(control, method=m, cost="surface").control for m in cases.METHODS}
    root = np.linalg.cholesky(surface_cost(embedded.rows))
    moved = {m: root.T @ (found - control).reshape(-1, 3) for m, found in results.items()}
    lengths = {m: np.linalg.norm(each) for m, each in moved.items()}
    assert lengths["nearest"] <= min(lengths.values()) * (1 + 1e-9)
    slope = np.linalg.solve(root, Solid.of(embedded).gradients(results["nearest"])[0])
    left = moved["nearest"] - slope * (np.sum(moved["nearest"] * slope) / np.sum(slope**2))
    assert np.linalg.norm(left) <= 1e-6 * lengths["nearest"]


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
