# SPDX-License-Identifier: GPL-3.0-or-later
"""Squash, taper, twist and bend of a lattice's control points by a few numbers.

All four act in the lattice's own orthonormal axes and in lengths of the world, its scale included: a twist turns
cross-sections rigidly however unevenly the lattice is scaled. Their axis runs through the middle of the undeformed
lattice along one of its three axes. On it t is 0 at the bottom and 1 at the top of the basis's domain, that is of the
grid for Bernstein, of the grid less the layers that B-splines need around it else. The pivot is at t₀ = 0, ½ or 1.
A point at t, as the animator left it, undergoes in this order:

- squash s: its distance from the plane t₀ times s. Nothing bulges.
- taper f: its distance from the axis times 1 + f·(t − t₀), never below 0: the top is wider than the bottom by the
  fraction f of the section at the pivot.
- twist a: a turn about the axis by a·(t − t₀), counter-clockwise where the axis points at the viewer.
- bend b: the axis, of the length that squash left it, becomes an arc of the angle b that touches the axis at the pivot
  and curves on either side of it to the bend direction; each cross-section stays plane, rigid and upright on it. A
  direction of 0 is the next of the axes X, Y, Z, X (for Z: X), a quarter turn the one after that (for Z: Y).

Beyond the outermost layers of the undeformed grid taper and twist stay what they are there, and the bend goes on along
the tangent. So for any pivot the whole turn from end to end is a, the arc's whole angle b; another pivot only moves
the result as a rigid whole, and scales the tapered section.
"""

from dataclasses import fields
from math import cos, isfinite, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import problem
from .grid import Grid, domain_box
from .settings import AXES, Shaping

Array = NDArray[np.float64]

PLACE_OF_PIVOT = {"Bottom": 0.0, "Centre": 0.5, "Top": 1.0}


def metric(lattice_matrix: Array, axis: str, before: Array | None = None) -> Array:
    """(3, 3) upper triangular, its diagonal positive: lattice space into orthonormal axes of the world's length unit,
    in the order of ``cyclic``, the first along ``axis``. ``lattice_matrix`` (4, 4) to world must be invertible.

    ``before`` is given back where the two differ by no more than the rounding of Blender's float32 matrices, so that
    a lattice that only moves and turns has the same numbers in every frame.
    """
    upper = np.linalg.qr(lattice_matrix[:3, cyclic(axis)])[1]
    upper = np.asarray(upper * np.sign(np.diag(upper))[:, None], np.float64)
    noise = 8.0 * np.finfo(np.float32).eps * np.abs(upper).max()
    return upper if before is None or np.abs(upper - before).max() > noise else before


def cyclic(axis: str) -> list[int]:
    """Indices of the axis and the two that follow it in turn."""
    first = AXES.index(axis)
    return [first, (first + 1) % 3, (first + 2) % 3]


def shaped(points: NDArray[Any], grid: Grid, upper: Array, shaping: Shaping) -> NDArray[Any]:
    """Blender's lattice points (flat xyz in lattice space), moved; float64, or the very same array where nothing moves.

    ``upper`` is ``metric`` of the shaping's axis. Raises problem.Problem where an input is not finite.
    """
    refuse_infinite(shaping)
    if shaping.is_neutral:
        return points
    order = cyclic(shaping.axis)
    centre = (np.array(grid.low) + np.array(grid.high)) / 2.0
    placed = (points.reshape(-1, 3).astype(np.float64) - centre)[:, order] @ upper.T
    moved = np.empty_like(placed)
    moved[:, order] = _moved(placed, *_ends(grid, upper, shaping.axis), shaping) @ np.linalg.inv(upper).T
    shifted: Array = moved + centre
    return shifted.reshape(-1)


def refuse_infinite(shaping: Shaping) -> None:
    """Raises problem.Problem that names the inputs that hold no finite number, as after a division by zero."""
    values = [(field.name, getattr(shaping, field.name)) for field in fields(shaping)]
    bad = [name for name, value in values if not isinstance(value, str) and not isfinite(value)]
    if bad:
        raise problem.Problem(problem.not_finite([name.replace("_", " ").title() for name in bad]))


def _ends(grid: Grid, upper: Array, axis: str) -> tuple[float, float]:
    """Length of the domain along the axis in world units, and of the whole grid as a multiple of it."""
    index = AXES.index(axis)
    low, high = domain_box(grid)
    size = high[index] - low[index]
    return float(upper[0, 0] * size), float(max(1.0, (grid.high[index] - grid.low[index]) / size))


def _moved(placed: Array, length: float, reach: float, shaping: Shaping) -> Array:
    """Points (P, 3) as (along the axis, across, across) about the lattice's middle, in world units."""
    place = placed[:, 0] / length + 0.5
    pivot = PLACE_OF_PIVOT[shaping.pivot]
    inside = np.clip(place, 0.5 - reach / 2.0, 0.5 + reach / 2.0) - pivot
    squashed = length * max(shaping.squash, 0.0)
    across = placed[:, 1:] * np.maximum(1.0 + shaping.taper * inside, 0.0)[:, None]
    across = _turned(across, shaping.twist * inside)
    on_axis = squashed * inside
    beyond = squashed * (place - pivot) - on_axis
    along, across = _bent(on_axis, beyond, across, shaping.bend * inside, shaping.bend_direction)
    return np.column_stack([along + length * (pivot - 0.5), across])


def _turned(across: Array, angle: Array) -> Array:
    one, other = across.T
    return np.column_stack([one * np.cos(angle) - other * np.sin(angle), one * np.sin(angle) + other * np.cos(angle)])


def _bent(on_axis: Array, beyond: Array, across: Array, turn: Array, direction: float) -> tuple[Array, Array]:
    """Along and across after the bend, from the pivot: ``on_axis`` is the length of the arc from there to the point's
    cross-section, ``turn`` the arc's angle up to it, ``beyond`` the way from it on along the tangent."""
    towards = np.array([cos(direction), sin(direction)])
    out = across @ towards
    sine, cosine = np.sin(turn), np.cos(turn)
    # sin x / x and (1 - cos x) / x, both without dividing by a small angle.
    rise, side = np.sinc(turn / np.pi), np.sin(turn / 2.0) * np.sinc(turn / (2.0 * np.pi))
    along = on_axis * rise - out * sine + beyond * cosine
    moved_out = on_axis * side + out * cosine + beyond * sine
    return along, across + (moved_out - out)[:, None] * towards
