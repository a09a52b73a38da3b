# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of `preserve` for methods, costs and limits, and what they promise on one mesh."""

import lattices
import meshes
import numpy as np
import oracle
import pytest
from isochor import VolumeError
from oracle import Spec

SPEC = Spec((7, 7, 7), "bspline", 3, "clamped")
MESH = meshes.bumpy_ball(3, 0.15)
METHODS = ["sweep", "balanced", "gradient", "nearest"]


def squashed() -> np.ndarray:
    return SPEC.centre + (lattices.noisy(SPEC, 0.05) - SPEC.centre) * [1.0, 0.9, 0.4]


@pytest.mark.parametrize("cost", ["points", "surface", "bending"])
@pytest.mark.parametrize("method", METHODS)
def test_every_method_and_cost_reaches_the_volume(method, cost):
    result = SPEC.build().bind(*MESH).preserve(squashed(), method=method, cost=cost)
    target = oracle.volume(*MESH)
    assert result.method == method
    about = (0.5, 0.5, 0.5)
    room = oracle.tolerance(result.vertices, MESH[1], about, target)
    assert oracle.volume(result.vertices, MESH[1], about) == pytest.approx(target, rel=room)
    assert result.missing == 0.0


def test_the_nearest_is_the_shortest_and_axes_are_a_mask():
    binding = SPEC.build().bind(*MESH)
    control = squashed()
    for axes in [(1, 1, 1), (1, 0, 1)]:
        found = {method: binding.preserve(control, axes=axes, method=method) for method in METHODS}
        assert min(found, key=lambda method: found[method].distance) == "nearest"
        for method in ("gradient", "nearest"):
            again = binding.preserve(control, axes=np.array(axes) * [3, 1, 7], method=method)
            assert np.array_equal(again.control, found[method].control)
            for axis in np.flatnonzero(np.array(axes) == 0):
                assert np.array_equal(found[method].control[..., axis], control[..., axis])


def test_unfolded_stops_before_the_fold_and_tells_what_is_missing():
    lattice = SPEC.build()
    binding = lattice.bind(*MESH)
    target = -0.5 * binding.reference_volume
    control = SPEC.centre + (lattices.noisy(SPEC, 0.01) - SPEC.centre) * [1.0, 0.9, 0.6]
    free = binding.preserve(control, axes=(0, 0, 1), target=target)
    held = binding.preserve(control, axes=(0, 0, 1), target=target, limit="unfolded")
    assert lattice.folds(free.control).verdict == "folded"
    assert lattice.folds(held.control).verdict == "unfolded"
    assert held.missing == pytest.approx(target - held.volume, abs=1e-12)
    assert held.missing < target / 2
    assert free.missing == 0.0


@pytest.mark.parametrize("word", ["method", "cost", "limit"])
def test_unknown_words_are_refused(word):
    with pytest.raises(VolumeError, match=f'{word}: found "furthest"'):
        SPEC.build().bind(*MESH).preserve(squashed(), **{word: "furthest"})
