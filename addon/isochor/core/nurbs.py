# SPDX-License-Identifier: GPL-3.0-or-later
"""The NURBS surface that Blender makes of control points, as fixed rows: each sample a mean of control points.

Blender's knots are whole numbers. Along one direction of n points and order k (degree k − 1) they go 0, 1, 2 … ; an
end point repeats the first k times and the last as well; Bézier repeats every inner knot k − 1 times; a cyclic
direction goes on with the knots it began with. The surface is sampled at n·r even steps (r the resolution): of an open
direction both ends included, of a cyclic one without its end, which is its beginning. A point's weight w makes the
rows rational: R = w B / Σ w B, with B the product of both directions' B-splines. So rows depend on the weights, never
on where the points are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Direction:
    """One direction of a surface, as Blender's splines hold it; ``order`` is the degree and one."""

    points: int
    order: int
    cyclic: bool
    endpoint: bool
    bezier: bool
    resolution: int

    @property
    def samples(self) -> int:
        """How many samples Blender takes along it."""
        return self.points * self.resolution

    @property
    def is_valid(self) -> bool:
        """Whether Blender draws it at all: a cyclic Bézier direction must consist of whole pieces."""
        if self.points < 2 or not 2 <= self.order <= self.points:
            return False
        if not self.bezier:
            return True
        return (self.endpoint or self.points > self.order) and (not self.cyclic or self.points % (self.order - 1) == 0)


@dataclass(frozen=True)
class Rows:
    """(T,) samples as rows over P points: ``offsets`` (T + 1,), ``columns`` and ``weights`` of their entries; and
    ``quads`` (Q, 4) of samples."""

    offsets: Indices
    columns: Indices
    weights: Array
    quads: Indices


def knots(direction: Direction) -> Array:
    """Of the B-splines along one direction; cyclic ones are open ones of order − 1 points more."""
    order, cyclic = direction.order, direction.cyclic
    count = direction.points + order + (order - 1 if cyclic else 0)
    inner = order - 1 if direction.bezier else 1
    first = order - (1 if cyclic else 0) if direction.endpoint else min(2, inner) if direction.bezier else 1
    tail = 2 * order - 1 if cyclic else (order if direction.endpoint else 0)
    lone = 1 if direction.endpoint and cyclic else 0
    found, current, left = [0.0] * lone, float(lone), first
    while len(found) < count - tail:
        found.append(current)
        left -= 1
        if left == 0:
            current, left = current + 1.0, inner
    for index in range(tail):
        # The tail may be longer than what is before it, and then goes on with itself.
        found.append(current + found[index] - found[0])
    return np.array(found)


def basis(direction: Direction) -> Array:
    """(samples, points): value of each point's B-spline at each sample."""
    found, order, points = knots(direction), direction.order, direction.points
    total = points + (order - 1 if direction.cyclic else 0)
    start, end = found[order - 1], found[total]
    places = np.linspace(start, end, direction.samples, endpoint=not direction.cyclic)
    values = _splines(found, order, total, places)
    folded = values[:, :points].copy()
    folded[:, : total - points] += values[:, points:]
    return folded


def _splines(found: Array, order: int, total: int, places: Array) -> Array:
    """(places, total) by the recurrence of Cox and de Boor; at the very end the last interval that is not empty."""
    filled = np.flatnonzero(np.diff(found[: total + 1]) > 0.0)
    filled = filled[filled >= order - 1]
    spans = filled[np.clip(np.searchsorted(found[filled], places, side="right") - 1, 0, len(filled) - 1)]
    values = np.zeros((len(places), len(found) - 1))
    values[np.arange(len(places)), spans] = 1.0
    for degree in range(1, order):
        count = values.shape[1] - 1
        index = np.arange(count)
        values = _ramp(places, found[index], found[index + degree]) * values[:, :-1] + (
            1.0 - _ramp(places, found[index + 1], found[index + degree + 1])
        ) * values[:, 1:] * (found[index + degree + 1] > found[index + 1])
    return values[:, :total]


def _ramp(places: Array, low: Array, high: Array) -> Array:
    """(places, splines) from 0 at ``low`` to 1 at ``high``; 0 where these are the same."""
    width = high - low
    return np.where(width > 0.0, (places[:, None] - low) / np.where(width > 0.0, width, 1.0), 0.0)


def surface(u: Direction, v: Direction, weights: Array) -> Rows:
    """The samples of one spline: those along v next to each other, rows along u after one another. ``weights`` (P,) of
    its points, u fastest."""
    along_u, along_v = basis(u), basis(v)
    rows = np.einsum("ap,bq->abqp", along_u, along_v).reshape(u.samples * v.samples, -1) * weights
    rows /= rows.sum(axis=1, keepdims=True)
    used = rows != 0.0
    columns = np.nonzero(used)[1]
    offsets = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return Rows(offsets, columns, rows[used], _quads(u, v))


def _quads(u: Direction, v: Direction) -> Indices:
    """(Q, 4) wound as Blender winds them; closed over the end of cyclic directions."""
    numbers = np.arange(u.samples * v.samples).reshape(u.samples, v.samples)
    if u.cyclic:
        numbers = np.concatenate([numbers, numbers[:1]])
    if v.cyclic:
        numbers = np.concatenate([numbers, numbers[:, :1]], axis=1)
    corners = numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1], numbers[:-1, :-1]
    return np.stack([corner.ravel() for corner in corners], axis=1)
