# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lattice objects as Isochor lattices: where the rest grid stands, and in which order its points come.

A Blender lattice is, undeformed, an evenly spaced grid about its own origin, over the unit cube or, where a script
made it so, a larger box; its points are stored u fastest. Matrices are 4x4 float64 and map column vectors.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import isochor

from . import problem
from .arrays import same_array
from .blending import NATIVE_INTERPOLATION, Blending
from .settings import BSPLINE_DEGREE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Grid:
    """A lattice's resolution, the box of its undeformed points in its own space, the way from there into the space of
    the object that it deforms, and how its points blend, as ``Blending`` says."""

    shape: tuple[int, int, int]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    basis: str
    to_object: Array
    interpolation: tuple[str, str, str] | None = None
    weights: Array | None = field(default=None, repr=False)

    def same_as(self, other: "Grid | None") -> bool:
        """Whether the two grids hold the same numbers."""
        if other is None:
            return False
        box, other_box = (self.shape, self.low, self.high), (other.shape, other.low, other.high)
        return box == other_box and self.blends_as(other) and np.array_equal(self.to_object, other.to_object)

    def blends_as(self, other: "Grid | Blending") -> bool:
        """Whether points blend alike."""
        same = (self.basis, self.interpolation) == (other.basis, other.interpolation)
        return same and same_array(self.weights, other.weights)


def relative_transform(object_matrix: Array, lattice_matrix: Array, names: tuple[str, str]) -> Array:
    """inv(object) @ lattice, both to world, refused where a matrix flattens space. ``names``: object, lattice."""
    if abs(np.linalg.det(unit_columns(object_matrix))) < 1e-12:
        raise problem.Problem(problem.flat_object(names[0]))
    if abs(np.linalg.det(unit_columns(lattice_matrix))) < 1e-12:
        raise problem.Problem(problem.flat_lattice(names[1]))
    return np.linalg.inv(object_matrix) @ lattice_matrix


@dataclass
class Placing:
    """``relative_transform`` of two objects over many frames, worked out anew only where one of them has moved."""

    _moved: bytes = b""
    _found: Array | None = field(default=None, repr=False)

    def of(self, object_matrix: Array, lattice_matrix: Array, names: tuple[str, str]) -> Array:
        """The same as ``relative_transform``; of matrices that have not changed, the very same array."""
        here = object_matrix.tobytes() + lattice_matrix.tobytes()
        if self._found is None or here != self._moved:
            self._found = relative_transform(object_matrix, lattice_matrix, names)
            self._moved = here
        return self._found


def unit_columns(matrix: Array) -> Array:
    """The 3x3 part with columns of length one; a column of length zero stays zero."""
    columns = matrix[:3, :3]
    lengths = np.linalg.norm(columns, axis=0)
    return columns / np.where(lengths > 0.0, lengths, 1.0)


def steadied(transform: Array, before: Array | None, object_matrix: Array, lattice_matrix: Array) -> Array:
    """The transform ``before``, of another frame, where the two differ by no more than Blender's matrices are rounded.

    Object and lattice that move together differ so in every frame; taking that for motion would embed anew each time.
    """
    if before is None:
        return transform
    rounding = np.finfo(np.float32).eps * np.abs(np.linalg.inv(object_matrix)).max()
    noise = rounding * max(np.abs(object_matrix).max(), np.abs(lattice_matrix).max())
    return before if np.abs(transform - before).max() <= noise else transform


def degrees(shape: tuple[int, int, int]) -> tuple[int, int, int]:
    """Degree of the B-spline on each axis: cubic, or what the number of points allows."""
    u, v, w = (max(1, min(BSPLINE_DEGREE, points - 1)) for points in shape)
    return u, v, w


def layers_outside(points: int, degree: int) -> float:
    """Grid layers that stand outside a uniform B-spline's domain on each side of an axis."""
    return 0.0 if points == 1 else (degree - 1) / 2


def domain_box(grid: Grid) -> tuple[Array, Array]:
    """First and last corner, in lattice space, of what the basis reaches: the grid, less the layers that stand outside
    a B-spline's domain; one unit thick where the grid is flat. Blender's own basis reaches a cell further, where it
    moves vertices outside too: that counts as outside."""
    low, high = np.array(grid.low), np.array(grid.high)
    flat = np.array(grid.shape) == 1
    low, high = np.where(flat, low - 0.5, low), np.where(flat, high + 0.5, high)
    if grid.basis == "B-Spline":
        for axis, (points, degree) in enumerate(zip(grid.shape, degrees(grid.shape), strict=True)):
            inset = layers_outside(points, degree) * (high[axis] - low[axis]) / max(points - 1, 1)
            low[axis], high[axis] = low[axis] + inset, high[axis] - inset
    return low, high


def build_lattice(grid: Grid) -> isochor.Lattice:
    """The Isochor lattice whose rest control points are the grid's points, in object space."""
    transform = grid.to_object
    low, high = domain_box(grid)
    origin = transform[:3, :3] @ low + transform[:3, 3]
    edges = (transform[:3, :3] * (high - low)).T
    if grid.basis == "B-Spline":
        return isochor.Lattice(
            shape=grid.shape,
            basis="bspline",
            degree=degrees(grid.shape),
            knots="uniform",
            origin=origin,
            edges=edges,
            weights=grid.weights,
        )
    if grid.basis == "Blender" and grid.interpolation is not None:
        return isochor.Lattice(
            shape=grid.shape,
            basis="blender",
            interpolation=[NATIVE_INTERPOLATION[name] for name in grid.interpolation],
            origin=origin,
            edges=edges,
            weights=grid.weights,
        )
    return isochor.Lattice(shape=grid.shape, basis="bernstein", origin=origin, edges=edges, weights=grid.weights)


def control_points(grid: Grid, points: NDArray[Any]) -> Array:
    """Blender's lattice points (flat xyz in lattice space, u fastest) as (nu, nv, nw, 3) float64 in object space."""
    u, v, w = grid.shape
    cells = points.reshape(w, v, u, 3).transpose(2, 1, 0, 3).astype(np.float64)
    return cells @ grid.to_object[:3, :3].T + grid.to_object[:3, 3]


def in_order(values: NDArray[Any], shape: tuple[int, int, int]) -> Array:
    """One number for each of Blender's lattice points, u fastest, as (nu, nv, nw) float64."""
    u, v, w = shape
    return np.ascontiguousarray(values.reshape(w, v, u).transpose(2, 1, 0), np.float64)


def correction_frame(
    space: str, object_matrix: Array, to_object: Array, own_matrix: Array | None = None
) -> Array | None:
    """Rows: the directions that the shares of x, y and z mean, in object space. None is the object's own axes.
    ``own_matrix``, to world, of the object whose axes count where ``space`` is "Custom"; the world's where it is None.
    """
    if space == "Object":
        return None
    if space == "Lattice":
        return unit_columns(to_object).T
    to_own = np.asarray(np.linalg.inv(object_matrix), np.float64)
    if space == "Custom" and own_matrix is not None:
        to_own = to_own @ own_matrix
    return unit_columns(to_own).T
