# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a surface: corners of a triangle, and how much of each."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EDGES = ((0, 1), (1, 2), (2, 0))


def places(vertices: NDArray[np.floating[Any]], corners: NDArray[np.int32], weights: Array) -> Array:
    """(m, 3) in float64: sums of the vertices that ``corners`` (m, 3) name, each times its weight (m, 3)."""
    return np.asarray(np.einsum("ij,ijk->ik", weights, vertices[corners].astype(np.float64)))


def nearest(point: Array, corners: Array) -> tuple[int, Array]:
    """Which of the triangles (F, 3, 3), a corner a row, is nearest to a point, and the barycentric coordinates (3,) of
    the nearest point in it: none below 0, and 1 in all. A triangle without area counts with its edges."""
    candidates = [_above(point, corners), *(_on_edge(point, corners, *edge) for edge in EDGES)]
    distances = np.stack([_distances(point, corners, weights) for weights in candidates])
    kind, index = np.unravel_index(int(np.argmin(distances)), distances.shape)
    return int(index), candidates[int(kind)][int(index)]


def _above(point: Array, corners: Array) -> Array:
    """(F, 3) of the points straight above or below in the planes of the triangles; NaN where these are outside of the
    triangle, or there is no plane."""
    second, third = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    way = point - corners[:, 0]
    a, b, c = _products(second, second), _products(second, third), _products(third, third)
    d, e = _products(second, way), _products(third, way)
    determinant = a * c - b * b
    # Less is what rounding makes of three corners in a line.
    plane = determinant > np.finfo(np.float64).eps * a * c
    divisor = np.where(plane, determinant, 1.0)
    v, w = (c * d - b * e) / divisor, (a * e - b * d) / divisor
    inside = plane & (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    return np.where(inside[:, None], np.stack([1.0 - v - w, v, w], axis=1), np.nan)


def _on_edge(point: Array, corners: Array, first: int, second: int) -> Array:
    """(F, 3) of the nearest points on the edges from one corner to another."""
    way = corners[:, second] - corners[:, first]
    squared = _products(way, way)
    share = _products(way, point - corners[:, first]) / np.where(squared > 0.0, squared, 1.0)
    weights = np.zeros((len(corners), 3))
    weights[:, second] = np.clip(share, 0.0, 1.0)
    weights[:, first] = 1.0 - weights[:, second]
    return weights


def _distances(point: Array, corners: Array, weights: Array) -> Array:
    """(F,) squared; infinite where there is no point."""
    way = np.einsum("ij,ijk->ik", weights, corners) - point
    return np.nan_to_num(_products(way, way), nan=np.inf)


def _products(one: Array, other: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", one, other))
