# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines that show a deformed space: the lattice's own, and those on which two of its three parameters are constant."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import isochor

Points = NDArray[np.float32]
Array = NDArray[np.float64]
Indices = NDArray[np.int32]

RAMP = np.array(
    [
        (0.16, 0.47, 0.96, 1.0),
        (0.20, 0.84, 0.78, 1.0),
        (0.98, 0.90, 0.26, 1.0),
        (1.0, 0.55, 0.12, 1.0),
        (0.93, 0.13, 0.13, 1.0),
    ],
    np.float32,
)
"""Colours of control points, red, green, blue, alpha, from those that the correction left alone to those moved most."""


class Wanted(NamedTuple):
    """How the iso-parameter lines are laid: ``divisions`` of each side of the box, ``samples`` straight pieces a
    line at least, and whether lines inside the box are wanted or those on its faces only."""

    divisions: int = 8
    samples: int = 24
    inside: bool = False


@dataclass(frozen=True)
class Drawing:
    """What there is to draw of one modifier, in the deformed object's own space. Lines are pairs of points.

    ``lattice`` (2E, 3) and ``isolines`` (2S, 3) lines, ``points`` (P, 3) corrected control points, ``paths`` (2P, 3)
    from each control point as the animator set it to where the correction put it, ``moved`` (P, 3) the displacements.
    """

    lattice: Points = field(repr=False)
    isolines: Points = field(repr=False)
    points: Points = field(repr=False)
    paths: Points = field(repr=False)
    moved: Array = field(repr=False)


def drawing(
    lattice: isochor.Lattice, asked: Array, control: Array, wanted: Wanted | None, bound: bool = False
) -> Drawing:
    """What there is to draw of control points (nu, nv, nw, 3) as ``asked`` and as corrected (``control``); without
    iso-parameter lines where None of them are wanted. ``bound``: whether the lattice was shaped when its rest was set.
    """
    flat, before = control.reshape(-1, 3), asked.reshape(-1, 3)
    lines = np.empty((0, 3)) if wanted is None else isolines(lattice, control, wanted, bound)
    return Drawing(
        lattice=single(flat[neighbours(control.shape[:3]).reshape(-1)]),
        isolines=single(lines),
        points=single(flat),
        paths=single(np.stack([before, flat], axis=1).reshape(-1, 3)),
        moved=flat - before,
    )


@lru_cache(maxsize=16)
def neighbours(shape: tuple[int, ...]) -> Indices:
    """(E, 2) pairs of grid points next to each other along an axis, numbered in the order of [i, j, k]; not to be
    written into."""
    numbers = np.arange(np.prod(shape), dtype=np.int32).reshape(shape)
    pairs = []
    for axis, count in enumerate(shape):
        ends = np.take(numbers, np.arange(count - 1), axis), np.take(numbers, np.arange(1, count), axis)
        pairs.append(np.stack([end.reshape(-1) for end in ends], axis=1))
    return np.concatenate(pairs)


@lru_cache(maxsize=4)
def isoparameters(wanted: Wanted) -> Array:
    """(lines, samples + 1, 3) parameters along every line on which two of s, t, u are constant, evenly
    spaced; not to be written into."""
    steps = wanted.divisions * -(-wanted.samples // wanted.divisions)
    along, levels = np.linspace(0.0, 1.0, steps + 1), np.linspace(0.0, 1.0, wanted.divisions + 1)
    one, other = (level.reshape(-1) for level in np.meshgrid(levels, levels, indexing="ij"))
    if not wanted.inside:
        outer = np.isin(one, (0.0, 1.0)) | np.isin(other, (0.0, 1.0))
        one, other = one[outer], other[outer]
    lines = np.empty((3, len(one), len(along), 3))
    for axis in range(3):
        lines[axis, :, :, axis] = along
        lines[axis, :, :, (axis + 1) % 3] = one[:, None]
        lines[axis, :, :, (axis + 2) % 3] = other[:, None]
    return lines.reshape(-1, len(along), 3)


def isolines(lattice: isochor.Lattice, control: Array, wanted: Wanted, bound: bool = False) -> Array:
    """(2S, 3) straight pieces, as pairs of points, of the deformed space's iso-parameter lines."""
    parameters = isoparameters(wanted)
    flat = parameters.reshape(-1, 3)
    curves = np.asarray(lattice.evaluate(flat, control))
    if lattice.weights is not None and not bound:
        # The rational map alone does not leave the lattice at rest in its place: the mesh moves by its change.
        curves = curves - lattice.evaluate(flat, lattice.rest) + lattice.origin + flat @ np.asarray(lattice.edges)
    curves = curves.reshape(parameters.shape)
    pieces: Array = np.stack([curves[:, :-1], curves[:, 1:]], axis=2).reshape(-1, 3)
    return pieces


def colours(fractions: Array) -> NDArray[np.float32]:
    """(N, 4) of RAMP for fractions (N,) of the displacement that has the last colour; more is the last colour too."""
    places = np.clip(np.nan_to_num(fractions), 0.0, 1.0) * (len(RAMP) - 1)
    below = np.minimum(places.astype(np.int32), len(RAMP) - 2)
    share = (places - below)[:, None].astype(np.float32)
    mixed: NDArray[np.float32] = RAMP[below] * (1.0 - share) + RAMP[below + 1] * share
    return mixed


def lengths(moved: Array, to_world: Array) -> Array:
    """(P,) world lengths of displacements (P, 3) of an object with this 4x4 matrix to world."""
    found: Array = np.linalg.norm(moved @ to_world[:3, :3].T, axis=1)
    return found


def single(points: Array) -> Points:
    """The same in the precision that graphics cards take."""
    return np.ascontiguousarray(points, np.float32)
