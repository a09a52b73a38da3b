# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds: what is proved is so, what is found is there."""

from __future__ import annotations

import time

import isochor
import numpy as np
import pytest
from determinants import determinants, grid
from isochor import LatticeError
from lattices import OBLIQUE, SOLID, THIN, affine, noisy, rotation
from oracle import Spec
from refusals import refused

EVERY = {**SOLID, **THIN}
MIRROR = np.diag([1.0, 1.0, -1.0])


def spaced(spec: Spec, amount: float, seed: int):
    """Rest control points, each moved at random by up to `amount` of the distance to the next, about."""
    random = np.random.default_rng(seed).uniform(-amount, amount, (*spec.shape, 3)) / spec.shape
    return spec.rest + random @ np.asarray(spec.edges, dtype=float)


def samples(seed: int, count: int = 300):
    """The domain's corners, edges and faces, and random parameters inside."""
    return np.concatenate([grid(3), np.random.default_rng(seed).random((count, 3))])


@pytest.mark.parametrize("name", EVERY)
def test_affine_maps_are_unfolded_and_mirrored_ones_folded(name):
    spec = EVERY[name]
    lattice = spec.build()
    linear, offset = affine()
    for control in (spec.rest, spec.rest @ linear.T + offset, spec.rest @ rotation().T * 1e-3):
        control = control if min(spec.shape) > 1 else spec.rest + 3  # a thin lattice keeps its own edge
        folds = lattice.folds(control)
        assert (folds.verdict, bool(folds)) == ("unfolded", False), control
        assert folds.parameters.shape == folds.points.shape == folds.undecided.shape == (0, 3)
    if min(spec.shape) > 1:
        control = spec.rest @ MIRROR + offset
        folds = lattice.folds(control)
        assert (folds.verdict, bool(folds)) == ("folded", True)
        assert len(folds.points) >= 16**3
        assert not len(folds.undecided)
        assert np.all(np.ptp(folds.parameters, axis=0) > 0.9)
        np.testing.assert_allclose(folds.points, lattice.evaluate(folds.parameters, control), rtol=0, atol=0)


@pytest.mark.parametrize("name", EVERY)
def test_no_proof_where_a_sample_folds_and_no_fold_where_the_determinant_is_right(name):
    spec = EVERY[name]
    lattice = spec.build()
    for seed, amount in enumerate((0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0)):
        control = spaced(spec, amount, seed)
        folds = lattice.folds(control)
        found = determinants(spec, control, samples(seed))
        if folds.verdict == "unfolded":
            assert found.min() > -1e-9, f"moved by {amount}"
        elif folds.verdict == "folded":
            assert determinants(spec, control, folds.parameters).max() < 1e-9, f"moved by {amount}"


def test_random_lattices_are_decided():
    """Of hundreds of lattices, moved a little or a lot, all are proved or found to fold; mild ones are proved."""
    verdicts = []
    solid = list(SOLID.values())
    for case in range(600):
        amount = 0.05 + 2 * case / 600
        spec = solid[case % len(solid)]
        if max(spec.axis_degree(axis) for axis in range(3)) > 10:
            continue
        control = spaced(spec, amount, 1000 + case)
        folds = spec.build().folds(control)
        verdicts.append(folds.verdict)
        assert folds.verdict == "unfolded" or amount > 0.2, (spec, amount)
        wrong = determinants(spec, control, samples(case, 100)).min() < -1e-9
        assert folds.verdict == "folded" or not wrong, (spec, amount)
    assert verdicts.count("unfolded") > 100
    assert verdicts.count("folded") > 100
    assert verdicts.count("undecided") <= 3, verdicts.count("undecided")


def test_a_known_fold_is_found_where_it_is():
    """x = s + a s (1 - s) (1 - 2 s) has the slope 1 + a (1 - 6 s + 6 s²): negative where |s - ½| is small."""
    lattice = isochor.Lattice(shape=(4, 3, 2))
    for a, verdict in ((1.999, "unfolded"), (2.0, "undecided"), (2.001, "folded"), (4.0, "folded")):
        control = lattice.rest.copy()
        control[..., 0] = np.array([0, (1 + a) / 3, (2 - a) / 3, 1])[:, None, None]
        folds = lattice.folds(control)
        assert folds.verdict == verdict, a
        if verdict == "folded":
            half = np.sqrt(1 / 12 - 1 / (6 * a))
            assert np.all(np.abs(folds.parameters[:, 0] - 0.5) < half)
    np.testing.assert_allclose(np.abs(folds.parameters[:, 0] - 0.5).max(), half, atol=1 / 16)
    assert len(folds.points) == len(np.unique(folds.parameters, axis=0)) > 1000


def test_a_bend_past_a_full_turn_overlaps_without_folding():
    spec = Spec((24, 5, 4), "bspline", 3, "uniform")
    s, t, u = np.moveaxis(spec.rest, -1, 0)
    control = np.stack([(3 - t) * np.sin(7.5 * s), (t - 3) * np.cos(7.5 * s), u], axis=-1)
    assert spec.build().folds(control).verdict == "unfolded"


def test_measured_from_a_shape():
    spec = Spec((5, 5, 5), "bspline", 3, "clamped", edges=OBLIQUE)
    lattice = spec.build()
    mirrored, rest = noisy(spec, 0.02, 1) @ MIRROR, noisy(spec, 0.02, 2) @ MIRROR
    assert lattice.folds(mirrored).verdict == "folded"
    assert lattice.folds(mirrored, rest=rest).verdict == "unfolded"
    folds = lattice.folds(spec.rest, rest=rest)
    assert folds.verdict == "folded"
    assert len(folds.points) >= 16**3
    crumpled = noisy(spec, 0.6, 3)
    assert lattice.folds(crumpled).verdict == "folded"
    folds = lattice.folds(spec.rest, rest=crumpled)
    assert folds.verdict != "unfolded"
    assert len(folds.undecided) > 0


def test_the_deeper_the_more_is_decided():
    spec = Spec((8, 8, 8))
    lattice = spec.build()
    control = spaced(spec, 0.75, 1)
    order = {"undecided": 0, "unfolded": 1, "folded": 1}
    known = [order[lattice.folds(control, depth=depth).verdict] for depth in (0, 1, 2, 4, 8, 16, 24)]
    assert known == sorted(known)
    assert (known[0], known[-1]) == (0, 1)


def test_flat_and_collapsed_shapes_are_undecided():
    for spec in (Spec((4, 4, 4)), Spec((8, 7, 6), "bspline", 3, "uniform"), Spec((2, 2, 2))):
        lattice = spec.build()
        flat = spec.rest * [1, 1, 0]
        for control in (flat, flat @ rotation().T, np.zeros_like(flat)):
            folds = lattice.folds(control)
            assert (folds.verdict, bool(folds)) == ("undecided", False)
            assert len(folds.undecided) > 0
            assert np.isfinite(folds.undecided).all()
    lattice = isochor.Lattice(shape=(4, 4, 4))
    cone = lattice.rest * 2 - 1
    cone[..., :2] *= (1 - lattice.rest[..., 2:]) / 2
    folds = lattice.folds(cone)
    assert folds.verdict == "undecided"
    np.testing.assert_allclose(folds.undecided[:, 2], 1, atol=1e-3)  # at the tip


@pytest.mark.parametrize("size", [1e-90, 1e-30, 1e30, 1e90])
def test_any_size(size):
    spec = Spec((4, 4, 4), edges=tuple(map(tuple, (np.asarray(OBLIQUE) * size).tolist())))
    lattice = spec.build()
    assert lattice.folds(spaced(spec, 0.2, 4)).verdict == "unfolded"
    assert lattice.folds(spaced(spec, 5.0, 4)).verdict == "folded"
    assert lattice.folds(spec.rest * 1e150).verdict == "unfolded"


def test_far_from_the_origin():
    """Coordinates of a million keep ten digits of a lattice of size 1: plenty for a sign."""
    spec = Spec((4, 4, 4), origin=(1e6, -1e6, 1e6))
    lattice = spec.build()
    assert lattice.folds(spaced(spec, 0.2, 4)).verdict == "unfolded"
    assert lattice.folds(spec.rest @ MIRROR).verdict == "folded"


def test_wrong_arguments():
    lattice = isochor.Lattice(shape=(4, 4, 4))
    broken = lattice.rest.copy()
    broken[1, 2, 3, 0] = np.nan
    for control in (broken, lattice.rest[1:], "rest", None):
        with refused(LatticeError, "control"):
            lattice.folds(control)
    for rest in (broken, lattice.rest[1:], "rest"):
        with refused(LatticeError, "rest"):
            lattice.folds(lattice.rest, rest=rest)
    for depth in (-1, 25, 1.5, "deep"):
        with refused(LatticeError, "depth"):
            lattice.folds(lattice.rest, depth=depth)


def test_repr():
    lattice = isochor.Lattice(shape=(4, 4, 4))
    assert repr(lattice.folds(lattice.rest)) == 'Folds(verdict="unfolded", points=0, undecided=0)'


def test_fast_enough_to_draw():
    """A shape is looked at once when it is drawn; the limit is ten times what it takes on two busy cores."""
    spec = Spec((10, 10, 10), "bspline", 3, "uniform")
    lattice, control = spec.build(), spaced(spec, 0.3, 6)
    lattice.folds(control)
    took = []
    for _ in range(5):
        start = time.perf_counter()
        lattice.folds(control)
        took.append(time.perf_counter() - start)
    assert min(took) < 0.1, took
