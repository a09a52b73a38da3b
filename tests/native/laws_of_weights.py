# SPDX-License-Identifier: GPL-3.0-or-later
"""Rational lattices as projective maps: circles, projections, changes of parameter.

Sederberg's (14.1) is Σ w B P / Σ w B. The library adds to it what makes rest the identity, which does not depend on the
control points: `blended`, the difference from the lattice with all control points at the origin, is (14.1) itself.
"""

from __future__ import annotations

import lattices
import numpy as np
from laws_deforming import Run, law
from numpy.typing import NDArray
from oracle import Array, Spec

BLOCKS = {
    "bernstein": lattices.weighted(Spec((4, 3, 5))),
    "bernstein-8": lattices.weighted(Spec((9, 2, 3)), 5.0),
    "clamped": lattices.weighted(Spec((6, 5, 7), "bspline", (3, 2, 1), "clamped")),
    "uniform": lattices.weighted(Spec((6, 5, 7), "bspline", 3, "uniform")),
}


def blended(run: Run, spec: Spec, points: NDArray, control: Array) -> Array:
    """Σ w B control / Σ w B at points of the unit cube."""
    moved, origin = (run.deform(spec, points, pose, outside="extend") for pose in (control, np.zeros_like(control)))
    return moved - origin


def unit_points(run: Run, count: int = 200) -> NDArray:
    """Points of the unit cube, the corners among them."""
    return run.points(Spec(), count)


def arc_block(inner: float, outer: float, angle: float) -> tuple[Spec, Array]:
    """A quadratic block along s about the z axis from one radius (t = 0) to another, an arc of at most 180 degrees."""
    half, heights = angle / 2, np.array([0.0, 0.7])
    weights = np.array([1, np.cos(half), 1])
    turn = np.array([0, half, angle])
    stretch = 1 / weights
    control = np.zeros((3, 2, 2, 3))
    for j, radius in enumerate((inner, outer)):
        control[:, j, :, 0] = (radius * stretch * np.cos(turn))[:, None]
        control[:, j, :, 1] = (radius * stretch * np.sin(turn))[:, None]
    control[..., 2] = heights
    return Spec((3, 2, 2), weights=np.tile(weights[:, None, None], (1, 2, 2))), control


@law({str(degrees): degrees for degrees in (10, 90, 120)})
def a_quadratic_block_is_an_exact_arc(run: Run, degrees: int) -> None:
    """Every point lies on its circle, between the ends, to rounding; cubic without weights would miss by far more."""
    angle = np.radians(degrees)
    spec, control = arc_block(1.0, 2.0, angle)
    points = unit_points(run)
    found = blended(run, spec, points, control)
    radius = np.hypot(found[:, 0], found[:, 1])
    room = 1e-14 if run.dtype == np.float64 else 4e-6
    np.testing.assert_allclose(radius, 1 + points[:, 1].astype(float), rtol=0, atol=room)
    turned = np.arctan2(found[:, 1], found[:, 0])
    assert turned.min() > -room
    assert turned.max() < angle + room
    np.testing.assert_allclose(found[:, 2], 0.7 * points[:, 2].astype(float), rtol=0, atol=room)
    plain = Spec((3, 2, 2))
    missed = np.hypot(*blended(run, plain, points, control)[:, :2].T) - 1 - points[:, 1]
    assert np.abs(missed).max() > 3 * room


@law(BLOCKS)
def projections_carry_through(run: Run, spec: Spec) -> None:
    """A projective map of the weighted control points is that map of the result."""
    random = np.random.default_rng(7)
    control = random.uniform(-1, 1, (*spec.shape, 3))
    matrix = np.eye(4) + random.uniform(-0.2, 0.2, (4, 4))
    lifted = np.concatenate([control, np.ones((*spec.shape, 1))], axis=-1) @ matrix.T
    heavy = np.asarray(spec.weights) * lifted[..., 3]
    projected = Spec(spec.shape, spec.basis, spec.degree, spec.knots, weights=heavy)
    points = unit_points(run)
    here = np.pad(blended(run, spec, points, control), ((0, 0), (0, 1)), constant_values=1.0) @ matrix.T
    there = blended(run, projected, points, lifted[..., :3] / lifted[..., 3:])
    np.testing.assert_allclose(there, here[:, :3] / here[:, 3:], rtol=0, atol=4 * run.room(projected, control))


@law({name: spec for name, spec in BLOCKS.items() if spec.basis == "bernstein"})
def growing_weights_only_change_the_parameter(run: Run, spec: Spec) -> None:
    """Weights w cⁱ at t give what w gives at c t / (1 − t + c t): the same curve, run through at another pace."""
    c = 3.0
    control = np.random.default_rng(8).uniform(-1, 1, (*spec.shape, 3))
    growth = c ** np.arange(spec.shape[0])
    grown = Spec(spec.shape, weights=np.asarray(spec.weights) * growth[:, None, None])
    points = unit_points(run).astype(float)
    paced = points.copy()
    paced[:, 0] = c * points[:, 0] / (1 - points[:, 0] + c * points[:, 0])
    here, there = blended(run, spec, paced, control), blended(run, grown, points, control)
    np.testing.assert_allclose(there, here, rtol=0, atol=4 * run.room(grown, control))


@law(BLOCKS)
def a_point_of_overwhelming_weight_takes_all(run: Run, spec: Spec) -> None:
    """Of weights a million times lighter almost nothing is left, wherever the heavy one acts."""
    heavy = np.full(spec.shape, 1e-6)
    index = tuple(n // 2 for n in spec.shape)
    heavy[index] = 1.0
    control = np.random.default_rng(9).uniform(-1, 1, (*spec.shape, 3))
    alone = Spec(spec.shape, spec.basis, spec.degree, spec.knots, weights=heavy)
    points = lattices.fitted(alone, np.full((1, 3), 0.5))
    found = blended(run, alone, points, control)
    np.testing.assert_allclose(found, control[index][None], rtol=0, atol=1e-3)
