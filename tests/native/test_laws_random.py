# SPDX-License-Identifier: GPL-3.0-or-later
"""Random tasks with planted difficulties in rational lattices and Blender's: volume and pins exact, all together."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from corrections import Correction, Solid
from laws_deforming import NATIVE, RATIONAL
from oracle import Embedded, Spec
from test_random_corrections import for_each, seeds

DTYPES = {"float64": np.float64, "float32": np.float32}
SPECS = {"rational": cases.RATIONAL, "blender": cases.BLENDER}
COUNT = 12
each_kind = pytest.mark.parametrize("kind", SPECS)


def exact(kind: str, method: str, dtype: str, device: str = "cpu"):
    """Checks the case of a number."""

    def check(seed: int) -> None:
        case = cases.random_case(seed, specs=SPECS[kind]).in_dtype(DTYPES[dtype])
        try:
            result = case.bind(device).preserve(case.control, method=method, **case.arguments)
        except (isochor.VolumeError, isochor.PinError):
            if cases.solvable(case):
                raise
            return
        cases.check_exact(case, result)

    return check


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("method", cases.METHODS)
@pytest.mark.parametrize("trap", cases.TRAPS)
@each_kind
def test_volume_and_pins_all_together(kind, trap, method, dtype):
    for_each(seeds(trap, 300, COUNT), exact(kind, method, dtype))


@pytest.mark.parametrize("method", cases.METHODS[:3])
@each_kind
def test_the_closed_forms_with_the_functions_in_bs_place(kind, method):
    """Weights stay fixed, so equations (10)-(24) hold with rational functions or Blender's for B."""

    def check(seed: int) -> None:
        case = cases.random_case(seed, specs=SPECS[kind])
        if case.trap in ("flat", "wild", "dependent") or not cases.solvable(case):
            return
        asked = case.correction
        result = case.bind().preserve(case.control, method=method, **case.arguments)
        expected = getattr(asked, method)() if result.method == method else None
        assert expected is not None or method == "balanced" or asked.gradient() is None, f"{result.method} ran"
        if expected is not None:
            off = np.linalg.norm(result.control - expected) / max(np.linalg.norm(expected - case.control), 1e-300)
            assert off <= 1e-5, f"{result.method} differs from the closed form by {off:.1e} of it"

    for_each(range(7000, 7000 + 10 * COUNT), check)


@each_kind
def test_nearest_is_the_shortest(kind):
    def check(seed: int) -> None:
        case = cases.random_case(seed, specs=SPECS[kind])
        if case.trap in ("flat", "wild") or not cases.solvable(case):
            return
        asked, binding = case.correction, case.bind()
        ours = {
            m: asked.distance(binding.preserve(case.control, method=m, **case.arguments).control) for m in cases.METHODS
        }
        assert ours["nearest"] <= min(ours.values()) * (1 + 1e-6) + 1e-12, str(ours)

    for_each(range(8000, 8000 + 5 * COUNT), check)


@pytest.mark.parametrize("spec", [*RATIONAL.values(), *NATIVE.values()], ids=[*RATIONAL, *NATIVE])
def test_the_coefficients_are_the_volume_s_gradient(spec):
    """A tripwire for the oracle itself: its gradient predicts small changes of the measured volume."""
    mesh = lattices.fitted(spec, meshes.bumpy_ball(2, 0.2)[0]), meshes.bumpy_ball(2)[1]
    embedded = Embedded.of(spec, *mesh, outside="extend")
    control = lattices.noisy(spec, 0.2)
    step = 1e-6 * np.random.default_rng(1).normal(size=control.shape)
    slope = Solid.of(embedded).gradients(control)[0].reshape(control.shape)
    ahead, behind = (embedded.volume(control + side * step) for side in (1, -1))
    assert (ahead - behind) / 2 == pytest.approx(np.sum(slope * step), rel=1e-6)


@pytest.mark.parametrize("cost", ["points", "surface", "bending"])
@pytest.mark.parametrize("name", ["rational-bernstein", "rational-uniform", "blender-bspline", "blender-mixed"])
def test_every_cost_reaches_the_volume_and_is_the_least(name, cost):
    """And no random displacement that keeps the volume costs less in the surface's own measure."""
    spec = {**RATIONAL, **NATIVE}[name]
    vertices, triangles = meshes.bumpy_ball(3, 0.15)
    binding = spec.build().bind(vertices, triangles, outside="extend", device="cpu")
    control = lattices.deformed(spec, "squash", 0.4)
    result = binding.preserve(control, method="nearest", cost=cost)
    target = oracle.volume(vertices, triangles, spec.centre)
    room = oracle.tolerance(result.vertices, triangles, spec.centre, target)
    assert abs(oracle.volume(result.vertices, triangles, spec.centre) - target) <= room * target
    if cost == "surface":
        moved = {
            m: surface_cost(binding, control, binding.preserve(control, method="nearest", cost=m))
            for m in ("points", cost)
        }
        assert moved["surface"] <= moved["points"] * (1 + 1e-9)


def surface_cost(binding, control, result) -> float:
    return float(np.sum((result.vertices - binding.deform(control)) ** 2))


@pytest.mark.parametrize("name", ["rational-bernstein", "rational-uniform", "blender-bspline", "blender-cardinal"])
def test_islands_keep_their_volumes(name):
    spec = {**RATIONAL, **NATIVE}[name]
    vertices, triangles = meshes.two_islands()
    binding = spec.build().bind(vertices, triangles, bodies="islands", outside="extend", device="cpu")
    control = lattices.deformed(spec, "squash", 0.4)
    result = binding.preserve(control)
    assert binding.body_count == 2
    for body in range(2):
        faces = triangles[binding.body_of_triangle == body]
        target = oracle.volume(vertices, faces, spec.centre)
        room = oracle.tolerance(result.vertices, faces, spec.centre, target)
        assert abs(oracle.volume(result.vertices, faces, spec.centre) - target) <= room * abs(target)


@pytest.mark.parametrize("name", ["rational-bernstein", "blender-bspline", "blender-linear"])
def test_what_cannot_be_reached_is_said(name):
    """All frozen, or an axis that no point can move along: VolumeError, and the words say what holds it."""
    spec = {**RATIONAL, **NATIVE}[name]
    vertices, triangles = meshes.bumpy_ball(2, 0.2)
    binding = spec.build().bind(vertices, triangles, outside="extend", device="cpu")
    control = lattices.deformed(spec, "squash", 0.4)
    with pytest.raises(isochor.VolumeError):
        binding.preserve(control, weights=np.full(spec.shape, np.inf))
    outside = spec.build().bind(vertices + 50.0, triangles, outside="keep", device="cpu")
    with pytest.raises(isochor.VolumeError):
        outside.preserve(control, target=1.0)


def test_pins_and_frozen_layers_together():
    """Rational weights, a C1 joint, a pin: the pin lands, the layers stand, the volume is kept."""
    spec = lattices.weighted(Spec((6, 6, 6)))
    vertices, triangles = meshes.bumpy_ball(3, 0.1, centre=(0.5, 0.5, 0.25))
    binding = spec.build().bind(vertices, triangles, outside="keep", continuity=1, device="cpu")
    rest = spec.build().rest
    control = rest + 0.05 * np.random.default_rng(3).normal(size=rest.shape)
    frozen = spec.build().frozen(continuity=1, faces=("u0",))
    pinned = int(np.argmax(vertices[:, 2]))
    place = binding.deform(control)[pinned] + [0.02, -0.03, 0.05]
    for method in cases.METHODS:
        result = binding.preserve(control, pins=([pinned], [place]), method=method)
        np.testing.assert_allclose(result.vertices[pinned], place, rtol=0, atol=1e-12)
        target = oracle.volume(vertices, triangles, spec.centre)
        assert abs(oracle.volume(result.vertices, triangles, spec.centre) / target - 1) <= 1e-12
        held = Embedded.of(spec, vertices, triangles).deform(np.where(frozen[..., None], rest, result.control))
        np.testing.assert_allclose(result.vertices, held, rtol=0, atol=1e-12)


def test_the_oracle_s_nearest_is_ours():
    """Fixed-point iteration on the textbook's linearisation ends where the library's Newton does."""
    spec = lattices.weighted(Spec((4, 4, 4)), 4.0)
    mesh = meshes.bumpy_ball(2, 0.2)
    control = lattices.deformed(spec, "squash", 0.3)
    asked = Correction(Solid.of(Embedded.of(spec, *mesh)), control)
    result = spec.build().bind(*mesh, device="cpu").preserve(control, method="nearest")
    assert asked.stationarity(result.control) <= 1e-5
