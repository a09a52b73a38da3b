# SPDX-License-Identifier: GPL-3.0-or-later
"""Thousands of random tasks with planted difficulties: volume and pins exact, all together, by every method."""

import itertools

import cases
import isochor
import numpy as np
import pytest

DTYPES = {"float64": np.float64, "float32": np.float32}
BLOCK = 40


def seeds(trap: str, first: int = 0, count: int = BLOCK) -> range:
    """Numbers of the cases with that difficulty."""
    at = cases.TRAPS.index(trap)
    return range(at + first * len(cases.TRAPS), at + (first + count) * len(cases.TRAPS), len(cases.TRAPS))


def for_each(numbers, check) -> None:
    """All failures at once, each with the number of its case."""
    failures = []
    for seed in numbers:
        try:
            check(seed)
        except Exception as failure:  # noqa: BLE001 — whatever it is, the case that gave it must be named
            failures.append(f"case {seed}: {type(failure).__name__}: {str(failure).strip()[:300]}")
    assert not failures, f"{len(failures)} of {len(numbers)}:\n" + "\n".join(failures[:12])


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("method", cases.METHODS)
@pytest.mark.parametrize("trap", cases.TRAPS)
def test_volume_and_pins_all_together(trap, method, dtype):
    def check(seed: int) -> None:
        case = cases.random_case(seed).in_dtype(DTYPES[dtype])
        try:
            result = case.bind().preserve(case.control, method=method, **case.arguments)
        except (isochor.VolumeError, isochor.PinError):
            if cases.solvable(case):
                raise
            return
        cases.check_exact(case, result)

    for_each(seeds(trap), check)


@pytest.mark.parametrize("method", cases.METHODS)
@pytest.mark.parametrize("trap", cases.TRAPS)
def test_never_a_wild_lattice(trap, method):
    """No farther than the closed form goes: sweep and balanced are it, nearest and gradient stay near or below."""

    def check(seed: int) -> None:
        case = cases.random_case(seed)
        if not cases.solvable(case):
            return
        asked = case.correction
        result = case.bind().preserve(case.control, method=method, **case.arguments)
        may_fall_back = method == "balanced" or asked.gradient() is None
        assert result.method == method or may_fall_back, f"{result.method} ran"
        ran = {"sweep": asked.sweep, "balanced": asked.balanced, "gradient": asked.gradient}
        if result.method in ran:
            expected = ran[result.method]()
            assert expected is not None, "there is no root for the gradient's step"
            off = np.linalg.norm(result.control - expected) / max(np.linalg.norm(expected - case.control), 1e-300)
            assert off <= 1e-5, f"{result.method} differs from the closed form by {off:.1e} of it"
        else:
            assert asked.distance(result.control) <= asked.distance(asked.sweep()) * (1 + 1e-6)

    for_each(seeds(trap, BLOCK), check)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("trap", cases.TRAPS)
def test_nearest_is_no_longer_than_the_shortest_of_the_others(trap, dtype):
    def check(seed: int) -> None:
        case = cases.random_case(seed).in_dtype(DTYPES[dtype])
        if not cases.solvable(case):
            return
        binding, asked = case.bind(), case.correction
        results = {m: binding.preserve(case.control, method=m, **case.arguments) for m in cases.METHODS}
        ours = {m: asked.distance(r.control) for m, r in results.items()}
        others = min(ours[m] for m in cases.METHODS[:3])
        slack = ours["nearest"] * 1e-9 + unseen(case, results["nearest"])
        assert ours["nearest"] <= others + slack, str(ours)
        for m, r in results.items():
            assert abs(r.distance - ours[m]) <= 1e-6 * ours[m] + 1e-12 * np.abs(case.control).max(), f"distance of {m}"

    for_each(seeds(trap, 2 * BLOCK), check)


def unseen(case: cases.Case, result) -> float:
    """Length of a correction whose change of the volume is lost in the rounding that the test allows."""
    asked = case.correction
    slopes = (asked.solid.gradients(result.control)[0] @ asked.directions.T) * (asked.shares > 0)
    steepness = np.linalg.norm(slopes * np.sqrt(asked.mobility / asked.mobility.max())[:, None])
    return 4 * cases.room(case, result.vertices, result.target) * abs(result.target) / steepness


@pytest.mark.parametrize(("pinned", "dtype"), list(itertools.product([True, False], DTYPES)))
def test_a_target_of_its_own_and_any_amount(pinned, dtype):
    """Target V_pins + amount (target − V_pins): inflate, deflate, breathe; negative amounts too."""

    def check(seed: int) -> None:
        random = np.random.default_rng(seed)
        case = cases.random_case(seed, pinned).in_dtype(DTYPES[dtype])
        rest = float(case.correction.targets()[0]) or 1.0
        case.options |= {"target": rest * random.uniform(0.5, 2), "amount": random.uniform(-0.2, 1.5)}
        if cases.solvable(case):
            method = cases.METHODS[seed // 10 % 4]
            cases.check_exact(case, case.bind().preserve(case.control, method=method, **case.arguments))

    for_each(range(5000, 5000 + 2 * BLOCK), check)
