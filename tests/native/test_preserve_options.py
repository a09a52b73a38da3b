# SPDX-License-Identifier: GPL-3.0-or-later
"""What axes, frame, weights, amount, target and method mean in `preserve`."""

import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Embedded, Spec

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-10": Spec((10, 10, 10), "bspline", 3, "clamped"),
}
TURN = lattices.rotation()
FRAMES = {
    "rotated": TURN,
    "left-handed": TURN * [[1], [1], [-1]],
    "oblique": np.array([[1.0, 0.2, 0.1], [-0.3, 0.9, 0.4], [0.2, -0.5, 1.1]]),
    "unequal-lengths": np.diag([2.0, 0.25, 30.0]) @ TURN,
    "permuted": np.eye(3)[[2, 0, 1]],
}
MESH = meshes.bumpy_ball(3, 0.15)
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", ["sweep", "balanced"])


def embedded_of(spec: Spec) -> Embedded:
    return Embedded.of(spec, *MESH)


def squashed(spec: Spec) -> np.ndarray:
    """Loses 60 %, and is not symmetric."""
    return spec.centre + (lattices.noisy(spec, 0.08) - spec.centre) * [1.05, 0.95, 0.4]


def reached(result, target: float, about=(0.5, 0.5, 0.5)) -> None:
    room = oracle.tolerance(result.vertices, MESH[1], about, target)
    assert oracle.volume(result.vertices, MESH[1], about) == pytest.approx(target, rel=room)


@each_spec
@each_method
@pytest.mark.parametrize("shares", [(1, 1, 1), (1, 1, 0), (0, 0, 1), (1, 2, 0)], ids=str)
@pytest.mark.parametrize("frame", FRAMES)
def test_axes_mean_the_rows_of_frame(spec, method, shares, frame):
    rows, control, embedded = FRAMES[frame], squashed(spec), embedded_of(spec)
    result = spec.build().bind(*MESH).preserve(control, axes=shares, frame=rows, method=method)
    target = oracle.volume(*MESH)
    reached(result, target)
    moved = result.control - control
    expected = getattr(embedded, method)(control, shares, target, frame=rows) - control
    assert np.linalg.norm(moved - expected) <= 1e-9 * np.linalg.norm(expected)
    along = moved @ np.linalg.inv(rows)  # components along the rows
    np.testing.assert_allclose(along[..., np.array(shares) == 0], 0, atol=1e-13 * np.abs(along).max())


def test_the_identity_frame_is_no_frame():
    control = squashed(Spec())
    binding = Spec().build().bind(*MESH)
    plain, framed = binding.preserve(control), binding.preserve(control, frame=np.eye(3))
    np.testing.assert_allclose(framed.control, plain.control, rtol=0, atol=1e-14)


@each_method
@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("shares", [(1, 1, 0), (1, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0)], ids=str)
def test_axes_without_a_share_do_not_move_by_a_single_bit(method, dtype, shares):
    for spec in SPECS.values():
        control = squashed(spec)
        result = spec.build().bind(MESH[0].astype(dtype), MESH[1]).preserve(control, axes=shares, method=method)
        still = np.array(shares) == 0
        np.testing.assert_array_equal(result.control[..., still], control[..., still])


@each_method
def test_only_the_proportion_of_the_shares_counts(method):
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    unit = binding.preserve(control, axes=(0.2, 0.3, 0.5), method=method)
    for factor in (10, 1e-8, 1e12):
        scaled = binding.preserve(control, axes=np.array([0.2, 0.3, 0.5]) * factor, method=method)
        np.testing.assert_allclose(scaled.control, unit.control, rtol=0, atol=1e-13)


@each_method
def test_the_correction_turns_and_moves_with_the_scene(method):
    spec, offset = SPECS["uniform-6"], np.array([3.0, -4.0, 1.0])
    control = squashed(spec)
    here = spec.build().bind(*MESH).preserve(control, axes=(1, 2, 0), method=method)
    turned = spec.moved(TURN, offset).build().bind(MESH[0] @ TURN.T + offset, MESH[1])
    there = turned.preserve(control @ TURN.T + offset, axes=(1, 2, 0), frame=TURN.T, method=method)
    np.testing.assert_allclose(there.control, here.control @ TURN.T + offset, rtol=0, atol=1e-11)


@each_method
def test_winding_does_not_change_the_correction(method):
    control, spec = squashed(Spec()), Spec()
    result = spec.build().bind(*MESH).preserve(control, method=method)
    flipped = spec.build().bind(*meshes.inside_out(MESH)).preserve(control, method=method)
    np.testing.assert_allclose(flipped.control, result.control, rtol=0, atol=1e-12)
    assert flipped.target == pytest.approx(-result.target, rel=1e-14)
    assert flipped.method == method


@each_spec
@each_method
@pytest.mark.parametrize("amount", [0.0, 0.5, 1.0])
def test_amount_runs_from_the_deformed_volume_to_the_target(spec, method, amount):
    control = squashed(spec)
    before, reference = embedded_of(spec).volume(control), oracle.volume(*MESH)
    result = spec.build().bind(*MESH).preserve(control, method=method, amount=amount)
    expected = before + amount * (reference - before)
    assert result.target == pytest.approx(expected, rel=1e-12)
    reached(result, expected)
    if amount == 0:
        np.testing.assert_allclose(result.control, control, rtol=0, atol=1e-13)


@each_method
@pytest.mark.parametrize("factor", [0.1, 0.5, 3.0])
@pytest.mark.parametrize("amount", [0.3, 1.0])
def test_target_is_a_volume(method, factor, amount):
    spec = SPECS["uniform-6"]
    control, target = squashed(spec), factor * oracle.volume(*MESH)
    before = embedded_of(spec).volume(control)
    result = spec.build().bind(*MESH).preserve(control, method=method, target=target, amount=amount)
    expected = before + amount * (target - before)
    assert result.target == pytest.approx(expected, rel=1e-12)
    reached(result, expected)


@each_spec
@each_method
@pytest.mark.parametrize("spread", [1e1, 1e6, 1e12])
def test_large_weights_keep_control_points(spec, method, spread):
    control, embedded = squashed(spec), embedded_of(spec)
    weights = np.exp(np.random.default_rng(1).uniform(0, np.log(spread), spec.shape))
    result = spec.build().bind(*MESH).preserve(control, method=method, weights=weights)
    target = oracle.volume(*MESH)
    reached(result, target)
    expected = getattr(embedded, method)(control, (1, 1, 1), target, weights=weights) - control
    assert np.linalg.norm(result.control - control - expected) <= 1e-9 * np.linalg.norm(expected)


def test_only_the_proportion_of_the_weights_counts():
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    weights = np.random.default_rng(1).uniform(1, 9, Spec().shape)
    one = binding.preserve(control, weights=weights).control
    for factor in (1e-6, 1e9):
        np.testing.assert_allclose(binding.preserve(control, weights=weights * factor).control, one, atol=1e-12)


@each_spec
@each_method
def test_infinite_weights_freeze_exactly(spec, method):
    control, embedded = squashed(spec), embedded_of(spec)
    weights = np.random.default_rng(1).uniform(1, 9, spec.shape)
    weights[: spec.shape[0] // 2] = np.inf
    result = spec.build().bind(*MESH).preserve(control, method=method, weights=weights)
    np.testing.assert_array_equal(result.control[np.isinf(weights)], control[np.isinf(weights)])
    target = oracle.volume(*MESH)
    reached(result, target)
    expected = getattr(embedded, method)(control, (1, 1, 1), target, weights=weights)
    np.testing.assert_allclose(result.control, expected, rtol=0, atol=1e-9 * np.abs(expected - control).max())


def test_equal_weights_are_no_weights():
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    plain, weighted = binding.preserve(control), binding.preserve(control, weights=np.full(Spec().shape, 7.0))
    np.testing.assert_allclose(weighted.control, plain.control, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", ["bernstein-4", "uniform-6", "uniform-10"])
def test_a_squashed_ball_stays_round_from_above(name):
    """Balanced, x and y only: extents within 1 %; the additive sweep must be seen not to be round."""
    spec = Spec((10, 10, 10), "bspline", 3, "uniform") if name == "uniform-10" else SPECS[name]
    vertices, triangles = meshes.icosphere(4)
    control = lattices.deformed(spec, "squash", 0.64)
    binding = spec.build().bind(vertices, triangles)
    balanced, sweep = (binding.preserve(control, axes=(1, 1, 0), method=method) for method in ("balanced", "sweep"))
    assert balanced.method == "balanced"
    extent, crooked = np.ptp(balanced.vertices, axis=0), np.ptp(sweep.vertices, axis=0)
    assert extent[0] / extent[1] == pytest.approx(1, abs=0.01)
    assert crooked[0] / crooked[1] > 1.1
    assert extent[2] == pytest.approx(0.36 * np.ptp(vertices[:, 2]), rel=1e-9)


def test_balanced_moves_the_lattice_less_than_the_sweep():
    spec = Spec((10, 10, 10), "bspline", 3, "uniform")
    control = lattices.deformed(spec, "squash", 0.85)
    binding = spec.build().bind(*meshes.icosphere(3))
    moved = {m: np.linalg.norm(binding.preserve(control, method=m).control - control) for m in ("sweep", "balanced")}
    assert moved["balanced"] < moved["sweep"]


def test_balanced_is_the_default_method():
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    result = binding.preserve(control)
    assert result.method == "balanced"
    np.testing.assert_array_equal(result.control, binding.preserve(control, method="balanced").control)


def test_result_says_what_ran():
    result = Spec().build().bind(*MESH, device="cpu").preserve(squashed(Spec()), method="sweep")
    assert result.method == "sweep"
    assert "cpu" in str(result.device).lower()
    assert isinstance(result.iterations, int)
    assert result.iterations >= 1
