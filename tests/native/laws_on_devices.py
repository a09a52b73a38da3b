# SPDX-License-Identifier: GPL-3.0-or-later
"""The laws of free-form deformation, each a function of where it is tried (device, type) and of one lattice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import lattices
import numpy as np
from laws_deforming import EVERY, HULLS, NATIVE, POLYNOMIAL, RATIONAL, Run, law, oracle
from laws_papers import pt_in_lattice
from oracle import Spec


def chosen(over: dict[str, Spec], which: Callable[[Spec], bool]) -> dict[str, Spec]:
    """Those of a table for which something is so."""
    return {name: spec for name, spec in over.items() if which(spec)}


def axes_where(spec: Spec, which: Callable[[int], bool]) -> list[int]:
    """Axes with more than one point for which something is so."""
    return [axis for axis in range(3) if spec.shape[axis] > 1 and which(axis)]


def interpolates_ends(spec: Spec) -> bool:
    """Whether the corners of the domain go where the corner control points are."""
    if min(spec.shape) == 1:
        return False
    clamped = spec.basis == "bspline" and spec.knots == "clamped"
    return spec.basis == "bernstein" or clamped


def interpolates_all(spec: Spec) -> bool:
    """Whether every point of Blender's grid goes where its control point is."""
    return all(spec.axis_interpolation(axis) != "bspline" for axis in axes_where(spec, lambda _: True))


@law(EVERY)
def partition_of_unity(run: Run, spec: Spec) -> None:
    """Functions that sum to 1: a shifted lattice shifts every point as far."""
    points, shift = run.points(spec), np.array([0.3, -1.2, 0.7])
    moved = run.deform(spec, points, spec.build().rest + shift)
    np.testing.assert_allclose(moved, points + shift, rtol=0, atol=run.room(spec, shift))


@law(EVERY)
def rest_is_the_identity(run: Run, spec: Spec) -> None:
    """To the bit, where the points are outside too."""
    points = np.concatenate([run.points(spec), 3 * run.points(spec)])
    for outside in ("keep", "extend"):
        out = run.bind(spec, points, outside=outside).deform(spec.build().rest)
        np.testing.assert_array_equal(out, points)


@law(POLYNOMIAL)
def linear_precision(run: Run, spec: Spec) -> None:
    """Σ B P is affine where the control points are: an affine map of the lattice is that map of the mesh."""
    points, (linear, offset) = run.points(spec), lattices.affine()
    control = spec.rest @ linear.T + offset
    moved = run.deform(spec, points, control)
    np.testing.assert_allclose(moved, points @ linear.T + offset, rtol=0, atol=run.room(spec, control))


def reproduces_lines(spec: Spec, axis: int) -> bool:
    """Linear does everywhere, Catmull-Rom and B-spline where no tap is held at the border; Cardinal nowhere."""
    word = spec.axis_interpolation(axis)
    return word == "linear" or (word != "cardinal" and spec.shape[axis] >= 4)


@law(chosen(NATIVE, lambda spec: any(reproduces_lines(spec, a) for a in axes_where(spec, lambda _: True))))
def linear_precision_of_blenders_basis(run: Run, spec: Spec) -> None:
    """Displacements that are affine along those axes, away from the grid's border cells, move points affinely."""
    axes = axes_where(spec, lambda axis: reproduces_lines(spec, axis))
    unit = np.random.default_rng(4).random((150, 3))
    for axis in axes_where(spec, lambda axis: spec.axis_interpolation(axis) != "linear"):
        border = 1 / (spec.shape[axis] - 1)
        unit[:, axis] = border + unit[:, axis] * max(1 - 2 * border, 0)
    linear = np.zeros((3, 3))
    linear[axes] = np.random.default_rng(5).uniform(-1, 1, (len(axes), 3))
    points = lattices.fitted(spec, unit).astype(run.dtype)
    control = spec.build().rest + spec.parameters(spec.rest.reshape(-1, 3)).reshape(spec.rest.shape) @ linear
    expected = points + spec.parameters(points) @ linear
    moved = run.deform(spec, points, control, outside="extend")
    np.testing.assert_allclose(moved, expected, rtol=0, atol=run.room(spec, control))


@law(HULLS)
def convex_hull(run: Run, spec: Spec) -> None:
    """No direction in which a point has gone farther than the control point that went farthest; nor back."""
    points, rest = run.points(spec), spec.build().rest
    control = rest + lattices.noisy(spec, 0.8) - spec.rest
    directions = np.random.default_rng(6).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    room = run.room(spec, control)
    deformed = run.deform(spec, points, control)
    moved, farthest = (deformed - points) @ directions.T, (control - rest).reshape(-1, 3) @ directions.T
    assert np.all(moved <= farthest.max(axis=0) + room)
    if not spec.by_displacement:
        assert np.all(deformed @ directions.T <= (control.reshape(-1, 3) @ directions.T).max(axis=0) + room)


@law(chosen(EVERY, interpolates_ends))
def end_points(run: Run, spec: Spec) -> None:
    """Corners go to the corner control points; faces depend on their own layer alone."""
    unit = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
    control = lattices.noisy(spec, 0.8)
    corners = control[np.ix_(*[(0, -1)] * 3)].reshape(-1, 3)
    moved = run.deform(spec, lattices.fitted(spec, unit), control, outside="extend")
    np.testing.assert_allclose(moved, corners, rtol=0, atol=run.room(spec, control))
    other = np.where((np.arange(spec.shape[0]) == 0)[:, None, None, None], control, spec.rest - control)
    face = np.random.default_rng(7).random((40, 3)) * [0, 1, 1]
    at = lattices.fitted(spec, face).astype(run.dtype)
    moved, again = (run.deform(spec, at, pose, outside="extend") for pose in (control, other))
    np.testing.assert_allclose(moved, again, rtol=0, atol=run.room(spec, control))


@law(chosen(NATIVE, interpolates_all))
def grid_points_are_interpolated(run: Run, spec: Spec) -> None:
    """Blender's linear and cardinal axes pass through their control points."""
    lattice = spec.build()
    control = lattice.rest + lattices.noisy(spec, 0.5) - spec.rest
    moved = run.deform(spec, lattice.rest.reshape(-1, 3), control, outside="extend")
    np.testing.assert_allclose(moved, control.reshape(-1, 3), rtol=0, atol=run.room(spec, control))


@law(EVERY)
def affine_invariance(run: Run, spec: Spec) -> None:
    """Moving lattice, control points and mesh by an affine map moves the result by it."""
    points, (linear, offset) = run.points(spec)[:-8], lattices.affine(12)
    moved = spec.moved(linear, offset)
    rest = spec.build().rest
    control = rest + lattices.noisy(spec, 0.5) - spec.rest
    here = run.deform(spec, points, control) @ linear.T + offset
    there = run.deform(moved, points @ linear.T + offset, control @ linear.T + offset, outside="extend")
    np.testing.assert_allclose(there, here, rtol=0, atol=4 * run.room(moved, control @ linear.T + offset))


@law(chosen(EVERY, lambda spec: spec.basis == "bernstein" and min(spec.shape) > 1))
def de_casteljau(run: Run, spec: Spec) -> None:
    """Hoff's algorithm, on homogeneous points where there are weights, gives the same."""
    points = run.points(spec, 30)
    control = lattices.noisy(spec, 0.6)
    heavy = np.ones(spec.shape) if spec.weights is None else np.asarray(spec.weights)
    lifted = np.concatenate([(control - spec.rest) * heavy[..., None], heavy[..., None]], axis=-1)
    found = np.array([pt_in_lattice(*place, lifted) for place in np.clip(spec.parameters(points), 0, 1)])
    expected = points + found[:, :3] / found[:, 3:]
    moved = run.deform(spec, points, control, outside="extend")
    np.testing.assert_allclose(moved, expected, rtol=0, atol=run.room(spec, control))


@law(EVERY)
def the_textbook(run: Run, spec: Spec) -> None:
    """Direct sums, for points inside and outside, kept or carried along, with an influence."""
    unit = np.random.default_rng(8).uniform(-0.8, 1.8, (300, 3))
    unit = unit[np.all((np.abs(unit) > 1e-3) & (np.abs(unit - 1) > 1e-3), axis=1)]
    points = np.concatenate([run.points(spec), lattices.fitted(spec, unit)]).astype(run.dtype)
    influence = np.random.default_rng(9).random(len(points))
    control = spec.build().rest + lattices.noisy(spec, 0.6) - spec.rest
    shifted = control - spec.build().rest + spec.rest
    for options in ({"outside": "keep"}, {"outside": "extend"}, {"outside": "extend", "influence": influence}):
        expected = oracle(spec, points, shifted, **options)
        found = run.deform(spec, points, control, **options)
        room = run.room(spec, control, points)
        np.testing.assert_allclose(found, expected, rtol=0, atol=room)


@law(POLYNOMIAL)
def equal_weights_are_the_polynomial(run: Run, spec: Spec) -> None:
    """Rational with all weights the same, whatever they are."""
    points, control = run.points(spec), lattices.noisy(spec, 0.6)
    plain = run.deform(spec, points, control)
    for weight in (1.0, 0.3, 4e5):
        same = replace(spec, weights=np.full(spec.shape, weight))
        np.testing.assert_allclose(run.deform(same, points, control), plain, rtol=0, atol=run.room(spec, control))


@law(RATIONAL)
def weights_count_only_in_proportion(run: Run, spec: Spec) -> None:
    """A common factor changes nothing; not a bit where it is a power of two."""
    points = run.points(spec)
    control = spec.build().rest + lattices.noisy(spec, 0.6) - spec.rest
    here = run.deform(spec, points, control)
    for factor in (2.0**-7, 2.0**10):
        scaled = replace(spec, weights=np.asarray(spec.weights) * factor)
        np.testing.assert_array_equal(run.deform(scaled, points, control), here)
    scaled = replace(spec, weights=np.asarray(spec.weights) / 3)
    np.testing.assert_allclose(run.deform(scaled, points, control), here, rtol=0, atol=run.room(spec, control))


@law(chosen(EVERY, lambda spec: spec.shape == (4, 4, 4) and spec.basis == "bernstein"))
def every_weight_pulls(run: Run, spec: Spec) -> None:
    """What the laws above must be able to see: a heavier control point draws the points near it to itself."""
    heavy = np.array(np.ones(spec.shape) if spec.weights is None else spec.weights, dtype=float)
    heavy[1, 2, 2] *= 50
    control = spec.rest.copy()
    control[1, 2, 2] += [0.2, 0.1, -0.3]
    at = lattices.fitted(spec, np.array([[1 / 3, 2 / 3, 2 / 3]]))
    light, pulled = (run.deform(s, at, control) - at for s in (spec, replace(spec, weights=heavy)))
    assert np.linalg.norm(pulled) > 1.5 * np.linalg.norm(light)
