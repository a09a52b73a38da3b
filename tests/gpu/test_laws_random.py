# SPDX-License-Identifier: GPL-3.0-or-later
"""Random tasks with planted difficulties on the GPU, in lattices of every kind: the campaign of tests/native."""

import cases
import isochor
import numpy as np
import pytest
from test_random_corrections import for_each, seeds

KINDS = {"polynomial": cases.SPECS, "rational": cases.RATIONAL, "blender": cases.BLENDER}
COUNT = 5


@pytest.mark.parametrize("method", cases.METHODS)
@pytest.mark.parametrize("trap", cases.TRAPS)
@pytest.mark.parametrize("kind", KINDS)
def test_volume_and_pins_all_together(kind, trap, method):
    def check(seed: int) -> None:
        case = cases.random_case(seed, specs=KINDS[kind]).in_dtype(np.float32)
        try:
            result = case.bind("gpu").preserve(case.control, method=method, **case.arguments)
        except (isochor.VolumeError, isochor.PinError):
            if cases.solvable(case):
                raise
            return
        cases.check_exact(case, result)

    for_each(seeds(trap, 700, COUNT), check)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_easy_runs_there(kind):
    """Where nothing is planted the GPU does the work itself: it does not quietly leave every case to the CPU."""
    ran = []
    for seed in seeds("none", 900, 12):
        case = cases.random_case(seed, pinned=False, specs=KINDS[kind]).in_dtype(np.float32)
        ran.append(case.bind("gpu").preserve(case.control, method="balanced", **case.arguments).device)
    assert ran.count("gpu") >= len(ran) / 2, ran
