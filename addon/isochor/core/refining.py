# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice with more points and the very same deformation.

What the lattice does to space is a sum of displacements of its points, so displacements are refined: by raising the
degree (Bernstein), or by dividing every span of a spline alike, which leaves points evenly spaced as Blender's are. The
box of a uniform cubic then shrinks, since less of it stands outside the domain. Where points have weights w, the
products w d and the weights are refined, and their quotients are the new displacements (Sederberg, CAGD, chapter 14).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import isochor

from .blending import Blending
from .grid import Grid, degrees, domain_box, in_order
from .native_lattice import bernstein, cubic_points, uniform_quadratic
from .problem import Problem
from .settings import AXES
from .words import Sentence

Array = NDArray[np.float64]
Shape = tuple[int, int, int]

MOST = 64
"""Points on a side of a Blender lattice."""
SPLINE, LINEAR, RAISED, FLAT = "spline", "linear", "raised", "flat"
"""Kinds of axes: a uniform B-spline, Blender's linear one, Bernstein, and one that has a single point for good."""


@dataclass(frozen=True)
class Refinement:
    """From the lattice ``before`` to the one ``after``, both in the space of the first."""

    before: Grid
    after: Grid

    def groups(self, groups: Array) -> Array:
        """(G, points after) weights of groups (G, points before), u fastest, in [0, 1]."""
        fields = np.array([in_order(group, self.before.shape) for group in groups])
        return np.clip(_flat(self._refined(fields)), 0.0, 1.0) if len(groups) else np.empty((0, self._count))

    def points(self, sets: NDArray[np.floating[Any]]) -> Array:
        """(K, points after, 3) for sets (K, points before, 3) of points, u fastest, in the space of the first."""
        moved = sets.astype(np.float64) - even_points(self.before)
        weights = self.before.weights
        fields = [in_order(moved[k, :, axis], self.before.shape) for k in range(len(sets)) for axis in range(3)]
        if weights is None:
            found = self._refined(np.array(fields))
        else:
            *products, total = self._refined(np.array([*(field * weights for field in fields), weights]))
            found = np.array(products) / total
        fine = _flat(found).reshape(len(sets), 3, self._count).transpose(0, 2, 1)
        return np.asarray(fine + even_points(self.after), np.float64)

    @property
    def _count(self) -> int:
        return int(np.prod(self.after.shape))

    def _refined(self, fields: Array) -> Array:
        """(F, nu, nv, nw) numbers over the points, over the new ones."""
        kinds = [kind(self.before, axis) for axis in range(3)]
        for axis in range(3):
            few = _few(kinds[axis], self.before.shape[axis], self.after.shape[axis])
            if few is not None:
                fields = np.moveaxis(np.tensordot(few, fields, (1, axis + 1)), 0, axis + 1)
        lattice, insert = _splines(kinds, fields.shape[1:], self.after.shape)
        rest = np.asarray(lattice.rest)
        sets = np.repeat(rest[None], -(-len(fields) // 3), axis=0)
        for number, values in enumerate(fields):
            sets[number // 3, ..., number % 3] += values
        if RAISED in kinds:
            finer, fine = lattice.refine(sets, shape=self.after.shape)
        else:
            finer, fine = lattice.refine(sets, insert=insert)
        apart = fine - np.asarray(finer.rest)
        return np.asarray(np.moveaxis(apart, -1, 1).reshape(-1, *self.after.shape)[: len(fields)])


def refinement(name: str, grid: Grid, asked: Shape) -> Refinement:
    """To so many points, 0 for the next finer lattice on that axis. Raises Problem where that would change the
    deformation, or there can be no more points."""
    u, v, w = (_wanted(name, grid, axis, asked[axis]) for axis in range(3))
    shape = u, v, w
    low, high = list(grid.low), list(grid.high)
    inner_low, inner_high = domain_box(grid)
    for axis in range(3):
        grows = grid.shape[axis] == 1 and shape[axis] > 1
        if kind(grid, axis) == SPLINE and shape[axis] != grid.shape[axis]:
            cell = (inner_high[axis] - inner_low[axis]) / (shape[axis] - 3)
            low[axis], high[axis] = float(inner_low[axis] - cell), float(inner_high[axis] + cell)
        elif grows:
            low[axis], high[axis] = float(inner_low[axis]), float(inner_high[axis])
    (a, b, c), (d, e, f) = low, high
    after = replace(grid, shape=shape, low=(a, b, c), high=(d, e, f), weights=None)
    return Refinement(grid, after)


def kind(grid: Grid, axis: int) -> str:
    """Which of the kinds an axis is."""
    if grid.basis == "Bernstein":
        return RAISED
    if grid.shape[axis] == 1:
        return FLAT
    return SPLINE if grid.basis == "B-Spline" else LINEAR


def refuse_basis(name: str, blending: Blending, shape: Shape) -> None:
    """Raises Problem where a lattice that blends so has no finer one with the same deformation."""
    types = blending.interpolation or ()
    axes = zip("UVW", types, shape, strict=False)
    smooth = [axis for axis, one, points in axes if points > 1 and one != "KEY_LINEAR"]
    if smooth:
        raise Problem(
            Sentence(
                "With the basis Blender only Linear interpolation stays the same with more points, but {axes} of"
                " “{name}” is smooth: leave its resolution, or use another basis.",
                axes=", ".join(smooth),
                name=name,
            )
        )


def even_points(grid: Grid) -> Array:
    """(N, 3) undeformed points, u fastest, in the lattice's own space."""
    u, v, w = (np.linspace(*ends) for ends in zip(grid.low, grid.high, grid.shape, strict=True))
    z, y, x = np.meshgrid(w, v, u, indexing="ij")
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def _wanted(name: str, grid: Grid, axis: int, asked: int) -> int:
    present, of_kind = grid.shape[axis], kind(grid, axis)
    if asked == present or (asked == 0 and present == 1):
        return present
    possible = [count for count in range(present + 1, MOST + 1) if _holds(of_kind, present, count)]
    if asked == 0 and possible:
        return possible[1] if of_kind == SPLINE and present < 4 else possible[0]
    if asked in possible:
        return asked
    if not possible:
        raise Problem(
            Sentence(
                "“{name}” has {count} points along {axis}: Blender holds none with more that deforms the same.",
                name=name,
                count=present,
                axis=AXES[axis],
            )
        )
    raise Problem(
        Sentence(
            "“{name}” has {present} points along {axis}; {asked} would deform otherwise. The same with {possible}{more}"
            " points, or 0 for the next.",
            name=name,
            present=present,
            axis=AXES[axis],
            asked=asked,
            possible=", ".join(map(str, possible[:3])),
            more=" …" if len(possible) > 3 else "",
        )
    )


def _holds(of_kind: str, present: int, count: int) -> bool:
    """Whether an axis with so many points can get ``count``, more, with the same deformation."""
    if of_kind in (RAISED, FLAT):
        return of_kind == RAISED
    if of_kind == SPLINE and present < 4:
        return count >= 4
    outer = 3 if of_kind == SPLINE else 1
    return (count - outer) % (present - outer) == 0


def _few(of_kind: str, before: int, after: int) -> Array | None:
    """(points after, points before) where an axis has too few points for the library's refinement; None elsewhere."""
    if before == after:
        return None
    if before == 1:
        return np.ones((after, 1))
    if of_kind == SPLINE and before < 4:
        return cubic_points(bernstein(1) if before == 2 else uniform_quadratic(), after - 3)
    return None


def _splines(
    kinds: list[str], shape: tuple[int, ...], after: Shape
) -> tuple[isochor.Lattice, tuple[list[float], list[float], list[float]]]:
    """The lattice over the unit cube that is refined, and the knots to insert on each axis."""
    u, v, w = shape
    if RAISED in kinds:
        return isochor.Lattice(shape=(u, v, w), basis="bernstein"), ([], [], [])
    if LINEAR in kinds:
        first, second, third = (_between(n - 1, m - 1) for n, m in zip(shape, after, strict=True))
        return isochor.Lattice((u, v, w), "bspline", 1, "clamped"), (first, second, third)
    # An axis that stays may have fewer points than a cubic needs.
    degree = degrees((u, v, w))
    first, second, third = (_between(n - d, m - d) for n, m, d in zip(shape, after, degree, strict=True))
    return isochor.Lattice((u, v, w), "bspline", degree, "uniform"), (first, second, third)


def _between(spans: int, wanted: int) -> list[float]:
    """Parameters that divide each of so many even spans over [0, 1] alike, to have as many as are wanted."""
    return [place / wanted for place in range(1, wanted) if spans > 0 and (place * spans) % wanted]


def _flat(fields: Array) -> Array:
    """(F, nu, nv, nw) numbers as (F, N), u fastest."""
    return np.asarray(fields.transpose(0, 3, 2, 1).reshape(len(fields), -1))
