# SPDX-License-Identifier: GPL-3.0-or-later
"""Slow, independent evaluation of what the library computes: textbook formulas, dense matrices, sums over faces.

`Spec` describes a lattice once and makes both the library's `Lattice` and the oracle's own numbers. `Embedded` is a
mesh in it: x = rows · P + constant with `rows` a dense (V, N) matrix. Sweep and balanced follow Hahmann et al. 2012,
equations (10)-(17), over faces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import isochor
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
INSIDE = 1e-9  # parameters this close to a face of the domain count as inside it (in units of the domain)


CUBIC = ("cardinal", "catmull-rom", "bspline")  # what Blender interpolates over four points; "linear" over two


@dataclass(frozen=True)
class Spec:
    """A lattice: the arguments of `isochor.Lattice`, its rest points (Greville) and its basis functions."""

    shape: tuple[int, int, int] = (4, 4, 4)
    basis: str = "bernstein"
    degree: int | tuple[int, int, int] = 3
    knots: str | tuple[ArrayLike, ArrayLike, ArrayLike] = "uniform"
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    edges: tuple[tuple[float, float, float], ...] = UNIT
    weights: ArrayLike | None = field(default=None, compare=False)  # (nu, nv, nw): rational
    interpolation: str | tuple[str, str, str] = "bspline"  # of basis "blender"

    def build(self) -> isochor.Lattice:
        """The library's lattice of this description."""
        frame = {"origin": self.origin, "edges": self.edges}
        if self.weights is not None:
            frame["weights"] = np.asarray(self.weights, dtype=float)
        if self.basis == "bernstein":
            return isochor.Lattice(shape=self.shape, **frame)
        if self.basis == "blender":
            return isochor.Lattice(shape=self.shape, basis="blender", interpolation=self.interpolation, **frame)
        return isochor.Lattice(shape=self.shape, basis=self.basis, degree=self.degree, knots=self.knots, **frame)

    def moved(self, linear: ArrayLike = UNIT, offset: ArrayLike = (0.0, 0.0, 0.0)) -> Spec:
        """The same lattice after the affine map x -> linear · x + offset of space."""
        linear = np.asarray(linear, dtype=float)
        origin, edges = linear @ self.origin + np.asarray(offset, dtype=float), np.asarray(self.edges) @ linear.T
        return replace(self, origin=tuple(origin.tolist()), edges=tuple(map(tuple, edges.tolist())))

    @property
    def centre(self) -> Array:
        """Middle of the domain, (3,)."""
        return np.asarray(self.origin, dtype=float) + np.sum(np.asarray(self.edges, dtype=float), axis=0) / 2

    @property
    def rest(self) -> Array:
        """(nu, nv, nw, 3) control points at their Greville abscissae."""
        abscissae = np.stack(np.meshgrid(*(self._greville(axis) for axis in range(3)), indexing="ij"), axis=-1)
        return abscissae @ np.asarray(self.edges, dtype=float) + np.asarray(self.origin, dtype=float)

    def parameters(self, points: ArrayLike) -> Array:
        """(V, 3) points in space to (s, t, u), [0, 1]³ inside the domain."""
        offsets = np.asarray(points, dtype=float) - self.origin
        return np.linalg.solve(np.asarray(self.edges, dtype=float).T, offsets.T).T

    @property
    def by_displacement(self) -> bool:
        """Whether vertices move by what control points have moved, because control points do not give positions."""
        return min(self.shape) == 1 or self.weights is not None or self.basis == "blender"

    def clamped(self, parameters: Array) -> Array:
        """Nearest parameters at which the basis still changes: of the domain; in Blender's one cell beyond it."""
        beyond = np.array([1 / max(n - 1, 1) for n in self.shape]) if self.basis == "blender" else np.zeros(3)
        return np.clip(parameters, -beyond, 1 + beyond)

    def matrix(self, parameters: Array) -> Array:
        """Dense (V, N) tensor-product weights, rational ones divided by their sum, N in C order of [i, j, k]."""
        u, v, w = (self.axis_weights(axis, parameters[:, axis]) for axis in range(3))
        product = np.einsum("vi,vj,vk->vijk", u, v, w).reshape(len(parameters), -1)
        if self.weights is None:
            return product
        heavy = product * np.ravel(self.weights)
        return heavy / heavy.sum(axis=1, keepdims=True)

    def axis_weights(self, axis: int, t: Array) -> Array:
        """(V, n) values of the n basis functions of one axis at t in [0, 1]."""
        count = self.shape[axis]
        if count == 1:
            return np.ones((len(t), 1))
        if self.basis == "blender":
            return blender(self.axis_interpolation(axis), count, t)
        if self.basis == "bernstein":
            return bernstein(count - 1, t)
        return cox_de_boor(self.knot_vector(axis), self.axis_degree(axis), t)

    def axis_degree(self, axis: int) -> int:
        """Polynomial degree along one axis."""
        if self.basis == "bernstein" or self.shape[axis] == 1:
            return self.shape[axis] - 1
        if self.basis == "blender":
            return 3 if self.axis_interpolation(axis) in CUBIC else 1
        return self.degree if isinstance(self.degree, int) else self.degree[axis]

    def axis_interpolation(self, axis: int) -> str:
        """Of Blender's basis along one axis."""
        return self.interpolation if isinstance(self.interpolation, str) else self.interpolation[axis]

    def knot_vector(self, axis: int) -> Array:
        """(n + degree + 1,) knots, the domain being [0, 1]."""
        count, degree = self.shape[axis], self.axis_degree(axis)
        if not isinstance(self.knots, str):
            return np.asarray(self.knots[axis], dtype=float)
        knots = (np.arange(count + degree + 1) - degree) / (count - degree)
        return np.clip(knots, 0, 1) if self.knots == "clamped" else knots

    def rounding(self, control: ArrayLike, epsilon: float) -> float:
        """Error to allow in an evaluated coordinate: a few ε of the control points, and parameters wrong by ε.

        A basis of degree d with n points changes by at most 2 d (n − d) max|P| per unit of its parameter; Blender's,
        whose cubics overshoot, by 8 n max|P|; a rational one by as much more as its weights differ.
        """
        slope = sum(2 * self.axis_degree(a) * (self.shape[a] - self.axis_degree(a)) for a in range(3))
        if self.basis == "blender":
            slope = 8 * sum(self.shape)
        if self.weights is not None:
            slope *= float(np.max(self.weights) / np.min(self.weights))
        return epsilon * (32 + 2 * slope) * float(np.abs(control).max())

    def _greville(self, axis: int) -> Array:
        count, degree = self.shape[axis], self.axis_degree(axis)
        if count == 1:
            return np.array([0.5])
        if self.basis == "bernstein":
            return np.arange(count) / degree
        if self.basis == "blender":
            return np.arange(count) / (count - 1)
        knots = self.knot_vector(axis)
        return np.array([knots[i + 1 : i + degree + 1].mean() for i in range(count)])


def bernstein(degree: int, t: Array) -> Array:
    """(V, degree + 1) Bernstein polynomials, from exact binomials."""
    return np.stack([math.comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)], axis=1)


def blender(interpolation: str, count: int, t: Array) -> Array:
    """(V, count) weights of Blender's lattice: four taps about the cell, those beyond the grid on its end points."""
    across = np.asarray(t, dtype=float) * (count - 1)
    cell = np.floor(across)
    x = across - cell
    weights = np.zeros((len(x), count))
    for tap, value in enumerate(_blender_taps(interpolation, x)):
        point = np.clip(cell + tap - 1, 0, count - 1).astype(int)
        weights[np.arange(len(x)), point] += value
    return weights


def _blender_taps(interpolation: str, x: Array) -> tuple[Array, Array, Array, Array]:
    """Weights of the points at −1, 0, 1 and 2 about a cell, at x in [0, 1] across it."""
    if interpolation == "linear":
        return 0 * x, 1 - x, x, 0 * x
    if interpolation == "bspline":
        outer, inner = (lambda y: y**3 / 6), (lambda y: y**3 / 2 - y**2 + 2 / 3)
        return outer(1 - x), inner(x), inner(1 - x), outer(x)
    c = {"cardinal": 0.71, "catmull-rom": 0.5}[interpolation]
    outer, inner = (lambda y: c * y**3 - c * y**2), (lambda y: (2 - c) * y**3 + (c - 3) * y**2 + 1)
    return outer(1 - x), inner(x), inner(1 - x), outer(x)


def cox_de_boor(knots: Array, degree: int, t: Array) -> Array:
    """(V, n) B-spline basis functions by the recursion; the domain's last point belongs to its last span."""
    last = int(np.flatnonzero(knots < knots[len(knots) - degree - 1]).max())
    t = t[:, None]
    values = ((knots[:-1] <= t) & (t < knots[1:])).astype(float)
    at_end = t[:, 0] >= knots[len(knots) - degree - 1]
    values[at_end] = np.arange(len(knots) - 1) == last
    for p in range(1, degree + 1):
        left = _ratio(t - knots[: -p - 1], knots[p:-1] - knots[: -p - 1])
        right = _ratio(knots[p + 1 :] - t, knots[p + 1 :] - knots[1:-p])
        values = left * values[:, :-1] + right * values[:, 1:]
    return values


def _ratio(numerator: Array, denominator: Array) -> Array:
    """numerator / denominator, and 0 where the denominator is 0 (a repeated knot)."""
    return np.where(denominator > 0, numerator / np.where(denominator > 0, denominator, 1), 0)


@dataclass
class Embedded:
    """A mesh in a lattice: deformed vertices are rows · P + constant."""

    spec: Spec
    triangles: NDArray[np.integer]
    rows: Array
    constant: Array

    @classmethod
    def of(cls, spec: Spec, vertices: ArrayLike, triangles, outside: str = "keep", influence=None) -> Embedded:
        """x + s (B P − x) inside; outside the domain x ("keep") or x + s B(nearest) (P − P_rest) ("extend").

        x + s B (P − P_rest) everywhere where control points do not give positions.
        """
        vertices = np.asarray(vertices, dtype=float)
        parameters = spec.parameters(vertices)
        axes = np.array(spec.shape) > 1
        inside = np.all(((parameters >= -INSIDE) & (parameters <= 1 + INSIDE)) | ~axes, axis=1)
        strength = np.ones(len(vertices)) if influence is None else np.asarray(influence, dtype=float)
        if outside == "keep":
            strength = np.where(inside, strength, 0.0)
        rows = strength[:, None] * spec.matrix(spec.clamped(parameters))
        relative = ~inside | spec.by_displacement
        rest = rows @ spec.rest.reshape(-1, 3)
        constant = np.where(np.reshape(relative, (-1, 1)), vertices - rest, (1 - strength)[:, None] * vertices)
        return cls(spec, np.asarray(triangles), rows, constant)

    def deform(self, control: ArrayLike) -> Array:
        """(V, 3) deformed vertices."""
        return self.rows @ np.asarray(control, dtype=float).reshape(-1, 3) + self.constant

    def volume(self, control: ArrayLike) -> float:
        """Signed volume of the deformed mesh."""
        return volume(self.deform(control), self.triangles, self.spec.centre)

    def coefficients(self, control: Array, direction: Array) -> Array:
        """(N,) ∂V/∂δ for control points moved along `direction`: equations (10)-(12), face by face."""
        corners = self.deform(control)[self.triangles]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return self.rows[self.triangles].sum(axis=1).T @ (areas @ direction) / 6

    def steps(self, control: ArrayLike, targets, shares, frame=None, weights=None) -> Array:
        """Control points after one axis after another has taken the volume to its entry of `targets`."""
        control = np.array(control, dtype=float)
        inverse = 1 / np.ones(control.shape[:3]) if weights is None else 1 / np.asarray(weights, dtype=float)
        for direction, share, target in zip(np.eye(3) if frame is None else np.asarray(frame), shares, targets):
            if share > 0:
                c = self.coefficients(control, direction)
                step = (target - self.volume(control)) * inverse.ravel() * c / np.sum(c * inverse.ravel() * c)
                control += step.reshape(control.shape[:3])[..., None] * direction
        return control

    def sweep(self, control: ArrayLike, shares, target: float, frame=None, weights=None) -> Array:
        """The paper's correction: each axis takes its share of the difference."""
        before, shares = self.volume(control), np.asarray(shares, dtype=float) / np.sum(shares)
        return self.steps(control, before + np.cumsum(shares) * (target - before), shares, frame, weights)

    def balanced(self, control: ArrayLike, shares, target: float, frame=None, weights=None) -> Array:
        """The same with geometric steps: volume V·(target/V)^(μ_1 + … + μ_a) after axis a."""
        before, shares = self.volume(control), np.asarray(shares, dtype=float) / np.sum(shares)
        return self.steps(control, before * (target / before) ** np.cumsum(shares), shares, frame, weights)


def volume(vertices: ArrayLike, triangles, about=(0.0, 0.0, 0.0)) -> float:
    """Signed volume about a point: products in extended precision, the sum over the triangles exact."""
    corners = (np.asarray(vertices, dtype=np.longdouble) - np.asarray(about, dtype=np.longdouble))[triangles]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    parts = (
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )
    high = parts.astype(np.float64)
    return math.fsum([*high.tolist(), *(parts - high).astype(np.float64).tolist()]) / 6


def area(vertices: ArrayLike, triangles) -> float:
    """Surface area."""
    corners = np.asarray(vertices, dtype=float)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(normals, axis=1).sum() / 2)


def tolerance(vertices: NDArray, triangles, about: ArrayLike, target: float) -> float:
    """Relative volume error that the dtype of `vertices` allows: 1e-12 or 1e-6, or 4 ε A R / |V| where that is larger.

    R is the largest coordinate about the point `about`, A the area.
    """
    floor = {np.dtype(np.float64): 1e-12, np.dtype(np.float32): 1e-6}[vertices.dtype]
    epsilon = float(np.finfo(vertices.dtype).eps)
    reach = float(np.abs(np.asarray(vertices, dtype=float) - np.asarray(about)).max())
    return max(floor, 4 * epsilon * area(vertices, triangles) * reach / abs(target))
