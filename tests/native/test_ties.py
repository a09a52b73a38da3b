# SPDX-License-Identifier: GPL-3.0-or-later
"""Ties between adjacent lattices through the Python module."""

import isochor
import numpy as np
import pytest
from isochor import LatticeError
from refusals import refused

BASES = {
    "bernstein": {"basis": "bernstein"},
    "uniform cubic": {"basis": "bspline", "degree": 3},
    "clamped quadratic": {"basis": "bspline", "degree": 2, "knots": "clamped"},
}


def pair(basis: dict, shapes=((5, 4, 4), (6, 4, 4))):
    """Two lattices that meet at x = 1, the second twice as long with s along -y and t along x."""
    a = isochor.Lattice(shape=shapes[0], **basis)
    n, p, q = shapes[1]
    edges = [[0.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    b = isochor.Lattice(shape=(p, n, q), origin=(1.0, 1.0, 0.0), edges=edges, **basis)
    return a, b


def shaken(lattice, seed: int):
    return lattice.rest + 0.2 * np.random.default_rng(seed).standard_normal(lattice.rest.shape)


@pytest.mark.parametrize("basis", BASES.values(), ids=BASES)
@pytest.mark.parametrize("continuity", [0, 1, 2])
@pytest.mark.parametrize("leader", ["a", "b"])
def test_places_and_derivatives_agree_across_the_joint(basis, continuity, leader):
    a, b = pair(basis)
    tie = isochor.Tie(a, "s1", b, "t0", continuity)
    assert tie.continuity == continuity
    control_a, control_b = shaken(a, 1), shaken(b, 2)
    assert (tie.gaps(control_a, control_b) > 0.05).all()
    if leader == "a":
        control_b = tie.apply(control_a, control_b)
    else:
        control_a = tie.apply(control_b, control_a, leader="b")
    assert tie.gaps(control_a, control_b).shape == (continuity + 1,)
    assert tie.gaps(control_a, control_b).max() < 1e-12
    y, z = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 5)))
    at = np.stack([np.ones_like(y), y, z], axis=1)
    place = lambda lattice, control, points: lattice.evaluate(lattice.parameters(points), control)  # noqa: E731
    np.testing.assert_allclose(place(a, control_a, at), place(b, control_b, at), atol=1e-12)
    if continuity:
        slopes = [
            lattice.derivative(lattice.parameters(at).clip(0, 1), control).transpose(0, 2, 1)
            @ np.linalg.inv(lattice.edges.T)
            for lattice, control in ((a, control_a), (b, control_b))
        ]
        np.testing.assert_allclose(*slopes, atol=1e-11)
    if continuity == 2:
        # One-sided second differences along x: their error falls with the step, their rounding rises with it.
        step = 1e-3 * np.array([1.0, 0.0, 0.0])
        bends = [
            (2 * f(0) - 5 * f(1) + 4 * f(2) - f(3)) / 1e-6
            for f in (
                lambda k: place(a, control_a, at - k * step),
                lambda k: place(b, control_b, at + k * step),
            )
        ]
        np.testing.assert_allclose(*bends, atol=1e-3)


def test_joined_lattices_move_a_mesh_across_them_without_a_crack():
    a, b = pair(BASES["bernstein"])
    tie = isochor.Tie(a, "s1", b, "t0", 1)
    control_a = shaken(a, 3)
    control_b = tie.apply(control_a, b.rest)
    line = np.stack([np.linspace(0.9, 1.1, 41), np.full(41, 0.3), np.full(41, 0.6)], axis=1)
    # On the face itself both move it: the second is kept from it.
    first = a.bind(line, device="cpu").deform(control_a)
    second = b.bind(line, device="cpu").deform(control_b)
    moved = np.where(line[:, :1] <= 1, first, second)
    steps = np.diff(moved, axis=0)
    assert np.linalg.norm(np.diff(steps, axis=0), axis=1).max() < 0.02 * np.linalg.norm(steps, axis=1).max()


def test_only_outer_layers_of_the_follower_change():
    a, b = pair(BASES["bernstein"])
    control_a, control_b = shaken(a, 3), shaken(b, 4)
    for continuity in range(3):
        tied = isochor.Tie(a, "s1", b, "t0", continuity).apply(control_a, control_b)
        changed = (tied != control_b).any(axis=(0, 2, 3))
        np.testing.assert_array_equal(changed, np.arange(6) <= continuity)


def test_what_cannot_be_tied_is_refused():
    a, b = pair(BASES["bernstein"])
    with refused(LatticeError, "apart", "s0"):
        isochor.Tie(a, "s0", b, "t0")
    with refused(LatticeError, "face"):
        isochor.Tie(a, "x1", b, "t0")
    with refused(LatticeError, "continuity", 4):
        isochor.Tie(a, "s1", b, "t0", continuity=5)
    with refused(LatticeError, "points of degree"):
        isochor.Tie(a, "s1", pair(BASES["bernstein"], ((5, 4, 4), (6, 3, 4)))[1], "t0")
    tie = isochor.Tie(a, "s1", b, "t0")
    with refused(LatticeError, "leader"):
        tie.apply(a.rest, b.rest, leader="c")
    with refused(LatticeError, "follower_control"):
        tie.apply(a.rest, a.rest)
