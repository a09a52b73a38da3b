# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions of the smallest box around points, whichever way it stands.

About an axis that is given, the smallest box has a side along an edge of the points' outline as seen along that axis:
that is found exactly. The search does so about each of the three axes in turn until the box gets no smaller, from
several starts: the object's own axes, the points' principal axes, and the best of directions spread over the sphere.
What it finds is the smallest box for a box however turned; elsewhere it may miss the very smallest by a little.
"""

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from .fit import THINNEST, right_handed

Array = NDArray[np.float64]

EXTREMES, STARTS, REFINED, ROUNDS = 1024, 48, 6, 30
"""Directions whose outermost points stand for all, directions that a search may start from, how many of those are
followed to the end, and after how many rounds at the latest."""


def oriented_axes(points: Array, like: Array) -> Array:
    """Orthonormal, right-handed columns along the smallest box around points (V, 3); in the order, and pointing the
    way, that is nearest to ``like`` (columns too), which are taken where no other box is smaller."""
    outer = outermost(points - points.mean(axis=0))
    _values, principal = np.linalg.eigh(np.cov(outer.T, bias=True))
    spread = [turned(outer, frame_about(direction), 0) for direction in directions(STARTS)]
    spread.sort(key=lambda axes: box_volume(outer, axes))
    starts = [like, principal, *spread[:REFINED]]
    found = min((refined(outer, axes) for axes in starts), key=lambda axes: box_volume(outer, axes))
    smaller = box_volume(outer, found) < (1.0 - 1e-9) * box_volume(outer, like)
    return nearest_order(found, like) if smaller else like


def box_volume(points: Array, axes: Array) -> float:
    """Volume of the box around the points along these axes, with the thickness that a lattice gets at least."""
    size = np.ptp(points @ axes, axis=0)
    return float(np.prod(np.maximum(size, THINNEST * size.max())))


def refined(points: Array, axes: Array) -> Array:
    """Axes turned about one of them at a time, until no such turn makes the box smaller."""
    volume = box_volume(points, axes)
    for _ in range(ROUNDS):
        best = min((turned(points, axes, axis) for axis in range(3)), key=lambda found: box_volume(points, found))
        smaller = box_volume(points, best)
        if smaller >= (1.0 - 1e-12) * volume:
            break
        axes, volume = best, smaller
    return axes


def turned(points: Array, axes: Array, axis: int) -> Array:
    """Axes turned about one of them so that the box is smallest."""
    one, other = axes[:, (axis + 1) % 3], axes[:, (axis + 2) % 3]
    outline = hull(points @ np.stack([one, other], axis=1))
    edges = np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(edges, axis=1)
    if not np.any(lengths > 0.0):
        return axes
    cosines, sines = (edges[lengths > 0.0] / lengths[lengths > 0.0][:, None]).T
    widths = np.ptp(np.outer(cosines, outline[:, 0]) + np.outer(sines, outline[:, 1]), axis=1)
    heights = np.ptp(np.outer(cosines, outline[:, 1]) - np.outer(sines, outline[:, 0]), axis=1)
    sizes = np.stack([widths, heights, np.full_like(widths, np.ptp(points @ axes[:, axis]))])
    place = np.argmin(np.prod(np.maximum(sizes, THINNEST * sizes.max(axis=0)), axis=0))
    result = axes.copy()
    result[:, (axis + 1) % 3] = cosines[place] * one + sines[place] * other
    result[:, (axis + 2) % 3] = cosines[place] * other - sines[place] * one
    return result


def hull(points: Array) -> Array:
    """Corners of the convex outline of points (N, 2), counter-clockwise (Andrew's monotone chain)."""
    ordered = [(float(x), float(y)) for x, y in np.unique(points, axis=0)]
    if len(ordered) < 3:
        return np.array(ordered)
    return np.array(half_hull(ordered)[:-1] + half_hull(ordered[::-1])[:-1])


def half_hull(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The side of the outline that keeps turning left on the way from the first point to the last."""
    chain: list[tuple[float, float]] = []
    for x, y in ordered:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            chain.pop()
        chain.append((x, y))
    return chain


def outermost(points: Array) -> Array:
    """The points that reach furthest in directions spread over the sphere, each once."""
    found = [np.argmax(some @ points.T, axis=1) for some in np.array_split(directions(EXTREMES), EXTREMES // 32)]
    outer: Array = points[np.unique(np.concatenate(found))]
    return outer


def directions(count: int) -> Array:
    """(count, 3) unit vectors spread evenly over the sphere, in a spiral."""
    place = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * place / count, np.pi * (1.0 + 5.0**0.5) * place
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def frame_about(direction: Array) -> Array:
    """Orthonormal columns, the first along the direction."""
    frame: Array = np.linalg.qr(np.column_stack([direction, np.eye(3)[np.argsort(np.abs(direction))[:2]].T]))[0]
    return frame


def nearest_order(axes: Array, like: Array) -> Array:
    """The same axes in the order, and turned the way, that is nearest to ``like``."""
    orders = [axes[:, list(order)] for order in permutations(range(3))]
    best = max(orders, key=lambda columns: float(np.abs(np.sum(columns * like, axis=0)).sum()))
    signs = np.sign(np.sum(best * like, axis=0))
    return right_handed(best * np.where(signs == 0.0, 1.0, signs))
