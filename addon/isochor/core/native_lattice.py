# SPDX-License-Identifier: GPL-3.0-or-later
"""Isochor's lattices as Blender's own Lattice modifier evaluates them, where the two can hold the very same map.

Blender's Lattice modifier knows per axis: KEY_LINEAR, which between two points is Bernstein's degree 1 and beyond them
follows the nearest end; and KEY_BSPLINE, the uniform cubic, whose domain is the grid less one layer on each side; and
two more, of which ours has its own basis "Blender", with the very points and types that Blender's lattice has. All
move points by the displacement of the control points, as ours do. So axis by axis, each independent of the others:

* one point, or degree 1: the same points, KEY_LINEAR;
* a uniform cubic: the same points, KEY_BSPLINE;
* one polynomial of degree 2 or 3 over the whole domain (Bernstein, or a uniform quadratic with three points): a uniform
  cubic whose cells, CELLS of them, fill the domain, so that the grid is one cell larger on each side.

Control points of that last kind. Let s run over [0, 1] in the domain and h be the width of a cell, so that the knots
stand at the multiples of h. The B-spline points of a cubic f are its polar form F at three knots in a row: c_j =
F((j-2) h, (j-1) h, j h) for j = 0 to CELLS + 2, where F is the symmetric function, linear in each argument, with
F(s, s, s) = f(s). For f = 1, s, s^2, s^3 it is 1, e1/3, e2/3, e3, with e1, e2, e3 the sum, the sum of the products of
two, and the product of the arguments; a lower degree needs no raising first. Rows sum to 1, and they carry the
undeformed points into an evenly spaced grid: so the same matrices hold for points and for displacements.

One cell would do (for Bernstein's cubic with the rows (6, -7, 2, 0), (0, 2, -1, 0), (0, -1, 2, 0), (0, 2, -7, 6)), but
such large weights magnify what float32 rounds off each point, the more the farther the outer knots are.
"""

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from .grid import Grid, build_lattice, degrees, layers_outside
from .settings import BSPLINE_DEGREE

Array = NDArray[np.float64]

LINEAR, BSPLINE = "KEY_LINEAR", "KEY_BSPLINE"
HIGHEST_DEGREE = 3
CELLS = 2
"""Cells of the uniform cubic that stands for one polynomial."""
ON_A_FACE = 1e-6
"""Distance from the domain, in its own size, at which a vertex in float32 counts as inside to the native library."""


@dataclass(frozen=True)
class NativeAxis:
    """One axis of the lattice that Blender evaluates: ``interpolation`` by Blender's name, ``matrix`` (new points, old
    points), and the first and last new point, undeformed, along the old lattice's axis."""

    interpolation: str
    matrix: Array
    low: float
    high: float
    is_blenders: bool = False
    """Whether ours blends as Blender's does, outside too."""

    @property
    def count(self) -> int:
        """Points of the new lattice along this axis."""
        return len(self.matrix)

    @property
    def follows_nearest(self) -> bool:
        """Whether a point beyond the domain moves as with ours that has Outside at Extend."""
        return self.is_blenders or self.interpolation == LINEAR


Axes = tuple[NativeAxis, ...]


def degree_of(grid: Grid, axis: int) -> int:
    """Polynomial degree along one axis, of Bernstein or B-Splines; 0 where there is one point."""
    points = grid.shape[axis]
    if points == 1:
        return 0
    return points - 1 if grid.basis == "Bernstein" else degrees(grid.shape)[axis]


def native_axes(grid: Grid) -> Axes:
    """The three axes of Blender's lattice; none where one has a degree above 3, which Blender does not know."""
    if grid.interpolation is not None:
        return tuple(_blenders_axis(grid, axis) for axis in range(3))
    if any(degree_of(grid, axis) > HIGHEST_DEGREE for axis in range(3)):
        return ()
    return tuple(_native_axis(grid, axis) for axis in range(3))


def _blenders_axis(grid: Grid, axis: int) -> NativeAxis:
    points, types = grid.shape[axis], grid.interpolation or (LINEAR, LINEAR, LINEAR)
    flat = 0.5 if points == 1 else 0.0
    return NativeAxis(types[axis], np.eye(points), grid.low[axis] - flat, grid.high[axis] + flat, True)


def _native_axis(grid: Grid, axis: int) -> NativeAxis:
    points, degree = grid.shape[axis], degree_of(grid, axis)
    low, high = grid.low[axis], grid.high[axis]
    if points == 1:
        return NativeAxis(LINEAR, np.eye(1), low - 0.5, high + 0.5)
    if degree == 1:
        return NativeAxis(LINEAR, np.eye(2), low, high)
    if grid.basis == "B-Spline" and degree == BSPLINE_DEGREE:
        return NativeAxis(BSPLINE, np.eye(points), low, high)
    if grid.basis == "B-Spline":
        inset = layers_outside(points, degree) * (high - low) / (points - 1)
        low, high = low + inset, high - inset
        polynomials = uniform_quadratic()
    else:
        polynomials = bernstein(degree)
    cell = (high - low) / CELLS
    return NativeAxis(BSPLINE, cubic_points(polynomials, CELLS), low - cell, high + cell)


def bernstein(degree: int) -> Array:
    """(degree + 1, degree + 1): row i holds the coefficients of Bernstein polynomial i, from the constant up."""
    found = np.zeros((degree + 1, degree + 1))
    for i in range(degree + 1):
        for k in range(i, degree + 1):
            found[i, k] = comb(degree, i) * comb(degree - i, k - i) * (-1) ** (k - i)
    return found


def uniform_quadratic() -> Array:
    """(3, 3): row i holds the coefficients over one cell of the uniform quadratic B-spline of point i."""
    return np.array([[0.5, -1.0, 0.5], [0.5, 1.0, -1.0], [0.0, 0.0, 0.5]])


def cubic_points(polynomials: Array, cells: int) -> Array:
    """(cells + 3, points): takes the control points of a basis of ``polynomials`` (points, degree + 1) over [0, 1] to
    those of the uniform cubic B-spline whose cells fill [0, 1]."""
    rows = []
    for j in range(cells + 3):
        a, b, c = (j - 2) / cells, (j - 1) / cells, j / cells
        polar = np.array([1.0, (a + b + c) / 3.0, (a * b + b * c + c * a) / 3.0, a * b * c])
        rows.append(polynomials @ polar[: polynomials.shape[1]])
    return np.array(rows)


def inside(grid: Grid, positions: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(V,) whether each of the (V, 3) vertices, in object space, is in the lattice's domain."""
    parameters = build_lattice(grid).parameters(np.asarray(positions, np.float64))
    beyond = np.abs(parameters - 0.5).max(axis=1) - 0.5
    return np.asarray(beyond <= ON_A_FACE, np.bool_)


def placement(axes: Axes) -> Array:
    """4x4: from the unit cube about the origin, where Blender's undeformed lattice stands, to the space of the old
    lattice."""
    matrix = np.eye(4)
    for axis, native in enumerate(axes):
        matrix[axis, axis] = native.high - native.low
        matrix[axis, 3] = (native.low + native.high) / 2.0
    return matrix


def native_points(axes: Axes, control: Array, to_object: Array) -> Array:
    """(points, 3) in the new lattice's own space, u fastest as Blender stores them. ``control`` (nu, nv, nw, 3) in
    object space; ``to_object`` from the new lattice's space to the object's."""
    matrices = [native.matrix for native in axes]
    points = np.einsum("ai,bj,ck,ijkx->cbax", *matrices, control).reshape(-1, 3)
    inverse = np.linalg.inv(to_object)
    found: Array = points @ inverse[:3, :3].T + inverse[:3, 3]
    return found
