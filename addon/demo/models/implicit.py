# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed surfaces from signed distances: surface nets, evened out on the surface that they approximate (numpy only)."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from .model import Array, Triangles

Field = Callable[[Array], Array]
"""Signed distance (..., ) of points (..., 3), negative inside."""

EVENING_ROUNDS = 6
"""Rounds of moving each vertex among its neighbours and back onto the surface: triangles are even then."""

STRIDE, NEAR = 3, 10.0
"""Only every third point of the grid is looked at first. One that stands for another is at most two steps off along
each axis, 3.5 steps in all: where the field is no steeper than 2.8, a value of ten steps has its sign all that way."""


def surface(field: Field, low: tuple[float, ...], high: tuple[float, ...], spacing: float) -> tuple[Array, Triangles]:
    """Points and outward triangles of where the field is 0, which must lie between the corners ``low`` and ``high``."""
    axes = [np.arange(start, end + spacing, spacing) for start, end in zip(low, high)]
    values = _sampled(field, np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1), spacing)
    _fill_doubtful(values, spacing)
    cells, places = _cell_points(values)
    triangles = _triangles(values < 0.0, cells)
    points = np.array([axis[0] for axis in axes]) + spacing * places
    return _evened(field, points, triangles, spacing), triangles


def _sampled(field: Field, grid: Array, spacing: float) -> Array:
    """The field on the grid: exact near the surface, elsewhere that of a point nearby, which has the same sign."""
    coarse = field(grid[::STRIDE, ::STRIDE, ::STRIDE])
    places = (np.arange(size) // STRIDE for size in grid.shape[:3])
    values = coarse[np.ix_(*places)]
    near = np.abs(values) < NEAR * spacing
    values[near] = field(grid[near])
    return values


def _fill_doubtful(values: Array, spacing: float) -> None:
    """Makes solid what would let two sheets of the surface meet in an edge: faces of cells that are solid at two
    opposite corners alone."""
    found = True
    while found:
        found = False
        for axis in range(3):
            a, b, c, d = _face_corners(values, axis)
            doubtful = ((a < 0.0) == (c < 0.0)) & ((b < 0.0) == (d < 0.0)) & ((a < 0.0) != (b < 0.0))
            found = found or bool(doubtful.any())
            for corner in (a, b, c, d):
                corner[doubtful] = np.minimum(corner[doubtful], -0.01 * spacing)


def _face_corners(values: Array, axis: int) -> list[Array]:
    """Views of the grid's values at the four corners, in turn, of every face of a cell across the axis."""
    turned = np.moveaxis(values, axis, 0)
    return [turned[:, :-1, :-1], turned[:, 1:, :-1], turned[:, 1:, 1:], turned[:, :-1, 1:]]


def _cell_points(values: Array) -> tuple[NDArray[np.int64], Array]:
    """Number of each cell's point, -1 where the surface is not in the cell; the points in units of the grid: the mean
    of where the surface crosses the cell's edges."""
    shape = tuple(size - 1 for size in values.shape)
    total, count = np.zeros((*shape, 3)), np.zeros(shape)
    for axis, *offset in product(range(3), (0, 1), (0, 1)):
        start = np.insert(np.array(offset), axis, 0)
        end = start + np.eye(3, dtype=int)[axis]
        near, far = (values[tuple(slice(o, o + n) for o, n in zip(corner, shape))] for corner in (start, end))
        crosses = (near < 0.0) != (far < 0.0)
        share = np.where(crosses, near / np.where(crosses, near - far, 1.0), 0.0)
        total += np.where(crosses, 1.0, 0.0)[..., None] * start
        total[..., axis] += share
        count += crosses
    found = count > 0
    cells = np.full(shape, -1, dtype=np.int64)
    cells[found] = np.arange(found.sum())
    return cells, np.argwhere(found) + total[found] / count[found][:, None]


def _triangles(solid: NDArray[np.bool_], cells: NDArray[np.int64]) -> Triangles:
    """Two for each edge of the grid that the surface crosses, between the points of the four cells about it."""
    found = []
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        ends = [np.take(solid, np.arange(a, solid.shape[axis] - 1 + a), axis) for a in (0, 1)]
        place = np.argwhere(ends[0] != ends[1])
        outwards = ends[0][tuple(place.T)]
        back_one, back_other = np.eye(3, dtype=int)[one], np.eye(3, dtype=int)[other]
        around = [place - back_one - back_other, place - back_other, place, place - back_one]
        a, b, c, d = (cells[tuple(corner.T)] for corner in around)
        quads = np.where(outwards[:, None], np.stack([a, b, c, d], axis=1), np.stack([d, c, b, a], axis=1))
        found += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    return np.ascontiguousarray(np.concatenate(found), dtype=np.int32)


def _evened(field: Field, points: Array, triangles: Triangles, spacing: float) -> Array:
    edges = np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    count = np.bincount(edges[:, 0], minlength=len(points))[:, None]
    for _ in range(EVENING_ROUNDS):
        sums = [np.bincount(edges[:, 0], points[edges[:, 1], axis], len(points)) for axis in range(3)]
        points = _onto(field, 0.5 * points + 0.5 * np.stack(sums, axis=1) / count, spacing)
    return _onto(field, points, spacing)


def _onto(field: Field, points: Array, spacing: float) -> Array:
    """One Newton step onto the surface, no longer than half the spacing."""
    reach = 0.05 * spacing
    steps = [np.where(np.arange(3) == axis, reach, 0.0) for axis in range(3)]
    gradient = np.stack([field(points + step) - field(points - step) for step in steps], axis=-1) / (2.0 * reach)
    length = np.maximum((gradient**2).sum(axis=-1), 0.1)
    step = np.clip(field(points) / length, -0.5 * spacing, 0.5 * spacing)
    moved: Array = points - step[:, None] * gradient
    return moved
