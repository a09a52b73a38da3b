# SPDX-License-Identifier: GPL-3.0-or-later
"""`limit="unfolded"`: the correction stops where it would itself fold the lattice, and says what volume is missing."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from determinants import determinants, grid
from oracle import Spec
from refusals import refused

SPECS = {"bernstein-4": Spec((4, 4, 4)), "uniform-7": Spec((7, 7, 7), "bspline", 3, "uniform")}
MESH = meshes.bumpy_ball(2, 0.2)
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", cases.METHODS)


def smallest_determinant(spec: Spec, control: np.ndarray) -> float:
    """Least det J over many points of the domain, its faces included, that at rest being 1."""
    inner = np.random.default_rng(0).random((1200, 3))
    return float(determinants(spec, control, np.concatenate([inner, grid(7)])).min())


def one_free_point(spec: Spec) -> dict:
    """All the volume that is missing has to come out of one control point: it folds long before it is there."""
    weights = np.full(spec.shape, np.inf)
    weights[(1, 1, 1) if spec.shape[0] == 4 else (1, 2, 3)] = 1.0
    return {"weights": weights}


def measured(result) -> float:
    return oracle.volume(result.vertices, MESH[1], (0.5, 0.5, 0.5))


@each_spec
@each_method
def test_a_correction_that_would_fold_stops_before_and_says_what_is_missing(spec, method):
    control, binding = lattices.deformed(spec, "squash", 0.4), spec.build().bind(*MESH)
    options = one_free_point(spec)
    assert smallest_determinant(spec, control) > 0.5
    free = binding.preserve(control, method=method, **options)
    assert smallest_determinant(spec, free.control) < 0
    result = binding.preserve(control, method=method, limit="unfolded", **options)
    assert smallest_determinant(spec, result.control) > -1e-6
    assert result.target == pytest.approx(oracle.volume(*MESH), rel=1e-12)
    assert measured(result) + result.missing == pytest.approx(result.target, rel=1e-12)
    before = binding.volume(control)
    assert before < measured(result) < result.target
    low, high = 0.0, 1.0
    for _ in range(10):
        middle = (low + high) / 2
        folds = smallest_determinant(spec, control + middle * (free.control - control)) < 0
        low, high = (low, middle) if folds else (middle, high)
    stopped = control + low * (free.control - control)
    # points see a fold later than its proof does
    assert measured(result) - before > 0.6 * (binding.volume(stopped) - before)
    assert result.error == pytest.approx(abs(result.missing / result.target), rel=1e-9)


@each_spec
@each_method
def test_a_correction_that_folds_nothing_is_left_alone(spec, method):
    control, binding = lattices.deformed(spec, "squash", 0.4), spec.build().bind(*MESH)
    plain = binding.preserve(control, method=method)
    assert smallest_determinant(spec, plain.control) > 0.1
    limited = binding.preserve(control, method=method, limit="unfolded")
    np.testing.assert_allclose(limited.control, plain.control, rtol=0, atol=1e-13)
    assert limited.missing == pytest.approx(0.0, abs=1e-14)
    assert limited.error <= 1e-12


@each_method
def test_pins_hold_where_the_correction_stops(method):
    spec = SPECS["bernstein-4"]
    control, binding = lattices.deformed(spec, "squash", 0.4), spec.build().bind(*MESH)
    weights = np.full(spec.shape, np.inf)
    weights[1:3, 1:3, 1:3] = 1.0
    places = binding.deform(control)[[9]] + [0.01, 0.0, 0.02]
    result = binding.preserve(control, method=method, weights=weights, pins=([9], places), limit="unfolded")
    np.testing.assert_allclose(result.vertices[9], places[0], rtol=0, atol=1e-12)
    assert measured(result) + result.missing == pytest.approx(result.target, rel=1e-12)
    assert smallest_determinant(spec, result.control) > -1e-6


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
def test_random_corrections_never_create_a_fold(dtype):
    """Whatever lattice does not fold before does not fold after, and volume and missing add up to the target."""
    limited = 0
    for seed in range(30):
        random = np.random.default_rng(seed)
        spec = list(SPECS.values())[seed % 2]
        control = spec.centre + (lattices.noisy(spec, 0.04, seed) - spec.centre) * random.uniform(0.3, 2, 3)
        if smallest_determinant(spec, control) < 1e-3:
            continue
        weights = np.exp(random.uniform(0, 8, spec.shape))
        binding = spec.build().bind(MESH[0].astype(dtype), MESH[1])
        method = cases.METHODS[seed // 2 % 4]
        result = binding.preserve(control, method=method, weights=weights, limit="unfolded")
        assert smallest_determinant(spec, result.control) > -1e-6, f"case {seed}"
        rel = 1e-12 if dtype == np.float64 else 1e-6
        assert measured(result) + result.missing == pytest.approx(result.target, rel=rel), f"case {seed}"
        limited += abs(result.missing) > 1e-6
    assert limited > 3


@pytest.mark.parametrize("limit", ["folded", "", 1, True], ids=repr)
def test_unknown_limit_lists_the_choices(limit):
    with refused(isochor.Error, "limit", "unfolded"):
        Spec().build().bind(*MESH).preserve(Spec().rest, limit=limit)
