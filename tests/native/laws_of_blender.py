# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own lattice, from its formula: four taps about a cell with their indices held at the grid's ends.

Written out point by point, with nothing of tensor products or B-splines in it; every interpolation, resolution and mix.
"""

from __future__ import annotations

import itertools
from math import floor

import lattices
import numpy as np
from laws_deforming import Run, law, native
from numpy.typing import NDArray
from oracle import Array, Spec

TYPES = ("linear", "cardinal", "catmull-rom", "bspline")
TENSION = {"cardinal": 0.71, "catmull-rom": 0.5}


def taps(word: str, t: float) -> tuple[float, float, float, float]:
    """Weights of the points i − 1, i, i + 1, i + 2 at t across cell i."""
    if word == "linear":
        return 0, 1 - t, t, 0
    if word == "bspline":
        return (
            -(t**3) / 6 + t**2 / 2 - t / 2 + 1 / 6,
            t**3 / 2 - t**2 + 2 / 3,
            -(t**3) / 2 + t**2 / 2 + t / 2 + 1 / 6,
            t**3 / 6,
        )
    fc = TENSION[word]
    return (
        -fc * t**3 + 2 * fc * t**2 - fc * t,
        (2 - fc) * t**3 + (fc - 3) * t**2 + 1,
        (fc - 2) * t**3 + (3 - 2 * fc) * t**2 + fc * t,
        fc * t**3 - fc * t**2,
    )


def axis_taps(word: str, count: int, parameter: float) -> list[tuple[int, float]]:
    """(point, weight) along one axis; the grid's first point at 0, its last at 1."""
    if count == 1:
        return [(0, 1.0)]
    across = parameter * (count - 1)
    i = floor(across)
    held = [min(max(i + k, 0), count - 1) for k in (-1, 0, 1, 2)]
    return list(zip(held, taps(word, across - i)))


def displaced(spec: Spec, point: Array, parameter: Array, displacement: Array) -> Array:
    """p + Σ w_w w_v w_u d."""
    axes = [axis_taps(spec.axis_interpolation(a), spec.shape[a], parameter[a]) for a in range(3)]
    moved = np.array(point, dtype=float)
    for (i, u), (j, v), (k, w) in itertools.product(*axes):
        moved += u * v * w * displacement[i, j, k]
    return moved


def mixes() -> dict[str, Spec]:
    """Every type at 1 to 9 points, and every third mix of three types at mixed resolutions."""
    plain = {f"{word}-{n}": native((n, max(10 - n, 1), 1 + n % 4), word) for word in TYPES for n in range(1, 10)}
    random = np.random.default_rng(6)
    mixed = {
        "-".join(words): native(tuple(random.integers(1, 8, 3).tolist()), words)
        for words in list(itertools.product(TYPES, repeat=3))[::3]
    }
    return plain | mixed


def scattered(run: Run, spec: Spec) -> NDArray:
    """Points inside, one cell beyond, far beyond, and on the grid itself."""
    random = np.random.default_rng(7)
    unit = np.concatenate([random.random((15, 3)), random.uniform(-0.6, 1.6, (15, 3)), random.uniform(-9, 9, (5, 3))])
    rest = spec.build().rest.reshape(-1, 3)
    return np.concatenate([unit, rest[:: max(len(rest) // 8, 1)]]).astype(run.dtype)


@law(mixes())
def blenders_formula(run: Run, spec: Spec) -> None:
    """Extend does what Blender does, Keep the same inside and nothing outside."""
    points, lattice = scattered(run, spec), spec.build()
    displacement = np.random.default_rng(8).uniform(-0.5, 0.5, lattice.rest.shape)
    parameters = points.astype(float)
    for axis in range(3):
        if spec.shape[axis] > 1:
            np.testing.assert_allclose(np.unique(lattice.rest[..., axis])[[0, -1]], [0, 1], rtol=0, atol=1e-15)
    expected = np.array([displaced(spec, p, p, displacement) for p in parameters])
    control = lattice.rest + displacement
    found = run.deform(spec, points, control, outside="extend")
    np.testing.assert_allclose(found, expected, rtol=0, atol=run.epsilon * 20 * (10 + 4 * max(spec.shape)))
    inside = np.all(((parameters >= 0) & (parameters <= 1)) | (np.array(spec.shape) == 1), axis=1)
    kept = run.deform(spec, points, control, outside="keep")
    np.testing.assert_array_equal(kept[inside], found[inside])
    np.testing.assert_array_equal(kept[~inside], points[~inside])


@law({word: word for word in TYPES})
def beyond_one_cell_everything_moves_alike(run: Run, word: str) -> None:
    """A point far outside moves as the nearest one a cell beyond the grid: the same bits."""
    spec = native((5, 5, 5), word)
    control = spec.rest + np.random.default_rng(3).uniform(-0.5, 0.5, spec.rest.shape)
    points = np.array([[1.25, 0.5, 0.5], [1.5, 0.5, 0.5], [9, 0.5, 0.5]], dtype=run.dtype)
    moved = run.deform(spec, points, control, outside="extend") - points
    np.testing.assert_allclose(moved[1:], moved[[0, 0]], rtol=0, atol=32 * run.epsilon)
    near = run.deform(spec, np.array([[1.1, 0.5, 0.5]]), control, outside="extend") - [[1.1, 0.5, 0.5]]
    if word != "linear":
        assert np.abs(near - moved[0]).max() > 1e-3


@law({word: word for word in TYPES})
def influence_scales_what_blender_moves(run: Run, word: str) -> None:
    """Vertex groups and Strength: p + s Σ w d."""
    spec = native((4, 3, 5), word)
    points = lattices.points_inside(spec, run.dtype, 60)
    influence = np.random.default_rng(4).random(len(points))
    control = spec.rest + np.random.default_rng(5).uniform(-0.5, 0.5, spec.rest.shape)
    whole = run.deform(spec, points, control) - points
    part = run.deform(spec, points, control, influence=influence) - points
    np.testing.assert_allclose(part, whole * influence[:, None], rtol=0, atol=32 * run.epsilon)
