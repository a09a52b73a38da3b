# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods "gradient" and "nearest": what they promise beyond the volume, and how they compare with the sweeps."""

import cases
import lattices
import meshes
import numpy as np
import oracle
import pytest
from corrections import Correction, Solid
from oracle import Embedded, Spec
from scipy.optimize import minimize

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-mixed": Spec((5, 4, 6), "bspline", (2, 3, 1), "clamped"),
}
MESH = meshes.bumpy_ball(2, 0.2)
# The largest part of the correction, in the weights' norm, that the multipliers may leave unexplained.
STATIONARY = 1e-7
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_new = pytest.mark.parametrize("method", ["gradient", "nearest"])
each_method = pytest.mark.parametrize("method", cases.METHODS)


def squashed(spec: Spec, seed: int = 5, height: float = 0.4) -> np.ndarray:
    return spec.centre + (lattices.noisy(spec, 0.08, seed) - spec.centre) * [1.05, 0.95, height]


def task(spec: Spec, control=None, chosen=(), **options):
    """The oracle's task and the arguments of `preserve`."""
    control = squashed(spec) if control is None else control
    embedded, chosen = Embedded.of(spec, *MESH), list(chosen)
    if not chosen:
        return Correction(Solid.of(embedded), control, **options), options
    moves = np.random.default_rng(1).uniform(-0.1, 0.1, (len(chosen), 3))
    asked = Correction(Solid.of(embedded), control, pin_rows=embedded.rows[chosen], pin_moves=moves, **options)
    return asked, options | {"pins": (chosen, embedded.deform(control)[chosen] + moves)}


WEIGHTS = {name: np.exp(np.random.default_rng(1).uniform(0, 4, spec.shape)) for name, spec in SPECS.items()}
VARIANTS = {
    "plain": {},
    "weights": {"weights": True},
    "horizontal": {"axes": (1.0, 1.0, 0.0)},
    "vertical": {"axes": (0.0, 0.0, 1.0)},
    "pins": {"chosen": (3, 77)},
    "turned": {"frame": lattices.rotation(), "axes": (1.0, 0.0, 1.0)},
    "all": {"weights": True, "axes": (0.0, 1.0, 1.0), "chosen": (3, 77), "frame": lattices.rotation(), "amount": 0.7},
}
each_variant = pytest.mark.parametrize("variant", VARIANTS)


def variant_of(spec: Spec, variant: str):
    options = dict(VARIANTS[variant])
    if "weights" in options:
        options["weights"] = next(WEIGHTS[name] for name, other in SPECS.items() if other is spec)
    return task(spec, **options)


@each_spec
@each_variant
def test_gradient_is_one_exact_step_along_the_gradient(spec, variant):
    asked, arguments = variant_of(spec, variant)
    result = spec.build().bind(*MESH).preserve(asked.control, method="gradient", **arguments)
    assert result.method == "gradient"
    pinned = asked.pinned()
    step = ((result.control - pinned).reshape(-1, 3) @ np.linalg.inv(asked.directions)).ravel()
    along = asked.direction(pinned).ravel()
    length = step @ along / (along @ along)
    np.testing.assert_allclose(step, length * along, rtol=0, atol=1e-10 * np.abs(step).max())
    np.testing.assert_allclose(result.control, asked.gradient(), rtol=0, atol=1e-9)


def test_gradient_takes_the_first_root_before_the_cubic_turns():
    """Random cubics: where the oracle finds a root it is taken, elsewhere the result says that another method ran."""
    spec, fell_back = Spec((3, 3, 3)), 0
    binding = spec.build().bind(*MESH)
    for seed in range(150):
        random = np.random.default_rng(seed)
        control = spec.centre + (lattices.noisy(spec, 0.5, seed) - spec.centre) * random.uniform(-1, 1, 3)
        asked = Correction(Solid.of(Embedded.of(spec, *MESH)), control, wanted=np.array([random.uniform(-0.5, 1.5)]))
        expected = asked.gradient()
        result = binding.preserve(control, method="gradient", target=float(asked.wanted[0]))
        fell_back += expected is None
        assert (result.method == "gradient") == (expected is not None), f"case {seed}: {result.method}"
        assert result.method in ("gradient", "balanced", "sweep")
        if expected is not None:
            off = np.abs(result.control - expected).max()
            assert off <= 1e-7 * np.abs(expected - control).max(), f"case {seed}"
        assert result.error <= cases.room(cases.Case("", spec, *MESH, control), result.vertices, result.target)
    assert 5 <= fell_back <= 145


def test_gradient_falls_back_to_balanced_and_says_so():
    """Within a plane the volume of a uniformly scaled shape is a square: it cannot be made negative."""
    spec = SPECS["bernstein-4"]
    binding = spec.build().bind(*meshes.icosphere(3))
    control = lattices.noisy(spec, 0.05)
    result = binding.preserve(control, method="gradient", axes=(1, 1, 0), target=-0.2)
    assert result.method == "sweep"  # balanced has no meaning where the sign turns, and falls back in its turn
    assert oracle.volume(result.vertices, meshes.icosphere(3)[1]) == pytest.approx(-0.2, rel=1e-12)


@each_spec
@each_variant
def test_nearest_is_a_kkt_point(spec, variant):
    asked, arguments = variant_of(spec, variant)
    result = spec.build().bind(*MESH).preserve(asked.control, method="nearest", **arguments)
    assert result.method == "nearest"
    assert asked.stationarity(result.control) <= STATIONARY
    assert 1 <= result.iterations <= 200  # two starts


@each_spec
@each_variant
def test_nearest_is_where_a_long_run_ends(spec, variant):
    asked, arguments = variant_of(spec, variant)
    result = spec.build().bind(*MESH).preserve(asked.control, method="nearest", **arguments)
    expected = asked.nearest(asked.balanced())
    off = np.linalg.norm(result.control - expected) / np.linalg.norm(expected - asked.control)
    assert off <= 1e-5
    assert result.distance == pytest.approx(asked.distance(expected), rel=1e-10)


@pytest.mark.parametrize("height", [0.1, 0.4, 2.5])
def test_no_optimiser_finds_anything_shorter(height):
    """SLSQP from where nearest ended, and from the lattices of two other methods."""
    spec = Spec((3, 2, 2))
    control = squashed(spec, height=height)
    asked, _ = task(spec, control)
    binding = spec.build().bind(*MESH)
    ours = binding.preserve(control, method="nearest")
    for method in ("balanced", "gradient", "nearest"):
        start = binding.preserve(control, method=method).control
        assert asked.distance(ours.control) <= _slsqp(asked, start) * (1 + 1e-5)


def _slsqp(asked: Correction, start: np.ndarray) -> float:
    """Length of the correction on which the optimiser settles; infinite where it fails."""
    shape, target, volumes, gradients = start.shape, asked.targets()[0], asked.solid.volumes, asked.solid.gradients
    found = minimize(
        lambda p: np.sum((p - asked.control.ravel()) ** 2),
        start.ravel(),
        jac=lambda p: 2 * (p - asked.control.ravel()),
        constraints=[
            {
                "type": "eq",
                "fun": lambda p: volumes(p.reshape(shape))[0] - target,
                "jac": lambda p: gradients(p.reshape(shape))[0].ravel(),
            }
        ],
        method="SLSQP",
        options={"ftol": 1e-10, "maxiter": 100},
    )
    reached = abs(volumes(found.x.reshape(shape))[0] - target) <= 1e-9 * abs(target)
    return float(np.sqrt(found.fun)) if reached else np.inf


@each_new
@each_spec
def test_shares_are_a_mask(spec, method):
    control, binding = squashed(spec), spec.build().bind(*MESH)
    for masks in [((1, 1, 1), (1, 2, 7)), ((1, 1, 0), (5, 0.1, 0)), ((0, 0, 1), (0, 0, 9))]:
        one, other = (binding.preserve(control, axes=axes, method=method).control for axes in masks)
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9)


@each_new
@pytest.mark.parametrize("order", [(1, 2, 0), (2, 1, 0), (0, 2, 1)], ids=str)
def test_permuting_the_axes_changes_nothing(method, order):
    """As rows of the frame, and as the scene itself; the sweep, which depends on the order, must fail it."""
    spec, order = SPECS["uniform-6"], list(order)
    asked, arguments = task(spec, chosen=(3, 77), axes=(1.0, 1.0, 0.0))
    binding, control = spec.build().bind(*MESH), asked.control
    plain = binding.preserve(control, method=method, **arguments).control
    framed = arguments | {"axes": np.array(arguments["axes"])[order], "frame": np.eye(3)[order]}
    np.testing.assert_allclose(binding.preserve(control, method=method, **framed).control, plain, rtol=0, atol=1e-9)

    swap = np.eye(3)[order]
    turned = spec.moved(swap).build().bind(MESH[0] @ swap.T, MESH[1])
    indices, places = arguments["pins"]
    moved = arguments | {"axes": np.array(arguments["axes"])[order], "pins": (indices, places @ swap.T)}
    there = turned.preserve(control @ swap.T, method=method, **moved).control
    np.testing.assert_allclose(there, plain @ swap.T, rtol=0, atol=1e-9)
    sweeps = [binding.preserve(control, method="sweep", axes=(1, 1, 1), frame=f).control for f in (None, swap)]
    assert order == [0, 1, 2] or np.abs(sweeps[0] - sweeps[1]).max() > 1e-4


@each_new
@each_spec
def test_with_all_axes_no_frame_changes_anything(spec, method):
    """They are round: rotating the directions, or tilting them, is no other correction."""
    control, binding = squashed(spec), spec.build().bind(*MESH)
    plain = binding.preserve(control, method=method).control
    for frame in (lattices.rotation(), lattices.rotation((3, -1, 2), 2.0)):
        turned = binding.preserve(control, method=method, frame=frame).control
        np.testing.assert_allclose(turned, plain, rtol=0, atol=1e-8)


@each_new
def test_the_correction_scales_turns_and_moves_with_the_scene(method):
    spec, turn, offset = SPECS["uniform-6"], lattices.rotation(), np.array([3.0, -4.0, 1.0])
    control = squashed(spec)
    here = spec.build().bind(*MESH).preserve(control, method=method).control
    for scale in (1.0, 1e-4, 1e4):
        linear, move = turn * scale, offset * scale
        there = spec.moved(linear, move).build().bind(MESH[0] @ linear.T + move, MESH[1])
        found = there.preserve(control @ linear.T + move, method=method).control
        np.testing.assert_allclose(found, here @ linear.T + move, rtol=0, atol=1e-8 * scale)


@each_new
def test_nothing_to_do_is_nothing_done(method):
    for spec in SPECS.values():
        result = spec.build().bind(*MESH).preserve(spec.rest, method=method)
        np.testing.assert_allclose(result.control, spec.rest, rtol=0, atol=1e-13)
        assert result.distance <= 1e-12


@pytest.mark.parametrize(
    ("height", "expected"),
    [
        (0.4, {"sweep": 7.16, "gradient": 4.91, "nearest": 4.58}),
        (0.15, {"sweep": 23.5, "gradient": 8.1, "nearest": 5.7}),
    ],
)
def test_lengths_of_a_squashed_sphere(height, expected):
    """A unit sphere that fills a lattice of 10³, cubic and clamped: what the methods cost, to the digits known.

    "Nearest" has saddles here, 4.65 for 4.57, where a method that only looks for stationary points may end.
    """
    spec = Spec((10, 10, 10), "bspline", 3, "clamped", (-1, -1, -1), ((2, 0, 0), (0, 2, 0), (0, 0, 2)))
    control = lattices.deformed(spec, "squash", 1 - height)
    binding = spec.build().bind(*meshes.icosphere(3, 1.0, (0, 0, 0)))
    for method, length in expected.items():
        result = binding.preserve(control, method=method)
        assert result.method == method
        assert result.distance == pytest.approx(np.linalg.norm(result.control - control), rel=1e-12)
        assert result.distance == pytest.approx(length, rel=0.02)


@pytest.mark.parametrize("height", [0.7, 0.36, 0.15])
def test_the_gradient_keeps_round_things_round(height):
    """To rounding, for it treats x and y alike. (The nearest lattice need not: at 0.15 an oval one is 4 % shorter.)"""
    spec = Spec((10, 10, 10), "bspline", 3, "uniform")
    control = lattices.deformed(spec, "squash", 1 - height)
    vertices, triangles = meshes.icosphere(4)
    binding = spec.build().bind(vertices, triangles)
    gradient, nearest = (binding.preserve(control, axes=(1, 1, 0), method=m) for m in ("gradient", "nearest"))
    extent = np.ptp(gradient.vertices, axis=0)
    assert extent[0] / extent[1] == pytest.approx(1, abs=1e-9)
    assert extent[2] == pytest.approx(height * np.ptp(vertices[:, 2]), rel=1e-9)
    assert nearest.distance <= gradient.distance
    if height > 0.3:
        extent = np.ptp(nearest.vertices, axis=0)
        assert extent[0] / extent[1] == pytest.approx(1, abs=1e-3)


@each_method
@each_spec
def test_a_result_tells_what_was_done(spec, method):
    asked, arguments = variant_of(spec, "all")
    result = spec.build().bind(*MESH).preserve(asked.control, method=method, **arguments)
    assert result.distance == pytest.approx(asked.distance(result.control), rel=1e-9)
    assert result.missing == 0.0
    assert result.volumes.shape == result.targets.shape == (1,)
    assert result.volumes.dtype == result.targets.dtype == np.float64
    assert result.volumes.sum() == pytest.approx(result.volume, rel=1e-14)
    assert result.targets.sum() == pytest.approx(result.target, rel=1e-14)
    assert result.error == pytest.approx(abs(result.volume - result.target) / abs(result.target), abs=1e-15)


def test_distance_is_in_units_of_the_lightest_weight():
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    weights = np.random.default_rng(1).uniform(1, 9, Spec().shape)
    results = [binding.preserve(control, weights=weights * factor, method="nearest") for factor in (1, 1e-6, 1e9)]
    moved = np.sum((results[0].control - control) ** 2, axis=-1)
    expected = np.sqrt(np.sum(weights / weights.min() * moved))
    for result in results:
        assert result.distance == pytest.approx(expected, rel=1e-9)


@each_method
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_flat_lattice_is_raised_again_by_the_one_axis_that_can(axis, method):
    spec = SPECS["bernstein-4"]
    control = lattices.noisy(spec, 0.05)
    control[..., axis] = 0.5
    result = spec.build().bind(*MESH).preserve(control, method=method)
    assert oracle.volume(result.vertices, MESH[1], spec.centre) == pytest.approx(oracle.volume(*MESH), rel=1e-12)
    assert np.abs(result.control - control).max() < 20
