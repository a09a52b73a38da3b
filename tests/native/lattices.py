# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices of every kind that the library knows, and ways an animator deforms them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from oracle import Array, Embedded, Spec

KNOTS = (
    (0, 0, 0, 0, 0.15, 0.5, 0.8, 1, 1, 1, 1),  # clamped, uneven
    (-0.7, -0.3, -0.1, 0, 0.2, 0.2, 0.9, 1, 1.4, 1.5, 2.5),  # unclamped, uneven, a double knot inside
    (-1, -0.5, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 1),  # one end of each sort
)
OBLIQUE = ((1.3, 0.2, -0.1), (-0.4, 1.1, 0.3), (0.25, -0.2, 1.2))

BERNSTEIN = {
    "bernstein-1": Spec((2, 2, 2)),
    "bernstein-3": Spec((4, 4, 4)),
    "bernstein-mixed": Spec((3, 6, 4)),
    "bernstein-20-1-7": Spec((21, 2, 8)),
    "bernstein-4-12-20": Spec((5, 13, 21)),
}
BSPLINE = {
    **{
        f"bspline-{degree}-{knots}": Spec((7, 6, 8), "bspline", degree, knots)
        for degree in range(1, 6)
        for knots in ("uniform", "clamped")
    },
    "bspline-one-span-uniform": Spec((4, 4, 4), "bspline", 3, "uniform"),
    "bspline-one-span-clamped": Spec((4, 4, 4), "bspline", 3, "clamped"),
    "bspline-mixed-uniform": Spec((5, 6, 9), "bspline", (1, 3, 5), "uniform"),
    "bspline-mixed-clamped": Spec((4, 10, 6), "bspline", (2, 5, 1), "clamped"),
    "bspline-10-uniform": Spec((10, 10, 10), "bspline", 3, "uniform"),
    "bspline-knot-arrays": Spec((7, 7, 7), "bspline", 3, KNOTS),
}
FRAMES = {
    "oblique": Spec((5, 4, 6), "bspline", 3, "uniform", (-0.3, 0.1, -0.2), OBLIQUE),
    "oblique-bernstein": Spec((4, 3, 5), origin=(-0.3, 0.1, -0.2), edges=OBLIQUE),
    "left-handed": Spec((4, 4, 4), origin=(1, 0, 0), edges=((-1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "tiny": Spec((6, 6, 6), "bspline", 2, "clamped", (3e-4, 0, 0), ((1e-3, 0, 0), (0, 2e-3, 0), (0, 0, 1e-3))),
    "huge": Spec((6, 6, 6), "bspline", 3, "uniform", (-5e3, 0, 0), ((1e4, 0, 0), (0, 1e4, 0), (0, 0, 3e4))),
    "needle": Spec((4, 4, 4), edges=((1e4, 0, 0), (0, 1, 0), (0, 0, 1e-3))),
}
SOLID = {**BERNSTEIN, **BSPLINE, **FRAMES}
THIN = {  # axes with one control point: displacements instead of positions
    "plane": Spec((4, 5, 1)),
    "plane-bspline": Spec((6, 1, 7), "bspline", 3, "clamped"),
    "line": Spec((1, 1, 8), "bspline", 3, "uniform"),
    "point": Spec((1, 1, 1)),
}


def weighted(spec: Spec, spread: float = 8.0, seed: int = 2) -> Spec:
    """The same lattice with rational weights, between 1/spread and spread."""
    return replace(spec, weights=spread ** np.random.default_rng(seed).uniform(-1, 1, spec.shape))


def points_inside(spec: Spec, dtype: type = np.float64, count: int = 200, seed: int = 3) -> NDArray:
    """(count + 8, 3) random points of the domain and its eight corners; in float32 those a millionth inside."""
    inset = 0.0 if dtype == np.float64 else 1e-6
    random = np.random.default_rng(seed).random((count, 3))
    corners = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), axis=-1).reshape(-1, 3)
    unit = np.clip(np.concatenate([random, corners]), inset, 1 - inset)
    return (unit @ np.asarray(spec.edges, dtype=float) + np.asarray(spec.origin)).astype(dtype)


def fitted(spec: Spec, vertices: ArrayLike) -> Array:
    """Vertices that lie in the unit cube, carried into the domain of `spec` by its affine frame."""
    return np.asarray(vertices, dtype=float) @ np.asarray(spec.edges, dtype=float) + np.asarray(spec.origin)


def affine(seed: int = 11) -> tuple[Array, Array]:
    """A random invertible (3, 3) matrix, far from singular, and an offset (3,)."""
    random = np.random.default_rng(seed)
    return np.eye(3) + random.uniform(-0.3, 0.3, (3, 3)), random.uniform(-2, 2, 3)


def rotation(axis: ArrayLike = (1, 2, 3), angle: float = 0.7) -> Array:
    """(3, 3) rotation matrix about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def noisy(spec: Spec, amount: float = 0.2, seed: int = 5) -> Array:
    """Rest control points, each moved at random by up to `amount` of the domain's edges."""
    random = np.random.default_rng(seed).uniform(-amount, amount, (*spec.shape, 3))
    return spec.rest + random @ np.asarray(spec.edges, dtype=float)


def deformed(spec: Spec, kind: str, strength: float) -> Array:
    """Control points after a named deformation about the domain's centre; strength 0 is rest."""
    offset = spec.rest - spec.centre
    return spec.centre + DEFORMATIONS[kind](offset, strength)


def to_ratio(embedded: Embedded, kind: str, ratio: float) -> Array:
    """Control points under which the volume is `ratio` times that at rest, by the least strength that gives it."""
    rest = embedded.volume(embedded.spec.rest)

    def excess(strength: float) -> float:
        return (embedded.volume(deformed(embedded.spec, kind, strength)) / rest - ratio) * np.sign(1 - ratio)

    high = next(s for s in np.linspace(0.02, 6, 300) if excess(s) <= 0)
    low = 0.0
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return deformed(embedded.spec, kind, high)


def with_frame(spec: Spec, origin: ArrayLike, edges: ArrayLike) -> Spec:
    """The same lattice over another domain."""
    rows = np.asarray(edges, dtype=float)
    return replace(spec, origin=tuple(np.asarray(origin, dtype=float).tolist()), edges=tuple(map(tuple, rows.tolist())))


def _squash(x: NDArray, s: float) -> NDArray:
    return x * [1, 1, 1 - s]


def _inflate(x: NDArray, s: float) -> NDArray:
    return x * (1 + s)


def _spread(x: NDArray, s: float) -> NDArray:
    return x * [1 + s, 1 + s, 1]


def _twist(x: NDArray, s: float) -> NDArray:
    angle = s * np.pi * x[..., 2]
    c, n = np.cos(angle), np.sin(angle)
    return np.stack([c * x[..., 0] - n * x[..., 1], n * x[..., 0] + c * x[..., 1], x[..., 2]], axis=-1)


def _dent(x: NDArray, s: float) -> NDArray:
    near = np.exp(-6 * np.sum((x - [0.5, 0, 0]) ** 2, axis=-1))
    return x - s * near[..., None] * [1.0, 0, 0]


def _wobble(x: NDArray, s: float) -> NDArray:
    random = np.random.default_rng(17).uniform(-1, 1, x.shape)
    return x * (1 - 0.6 * min(s, 1)) + 0.08 * s * random


DEFORMATIONS = {
    "squash": _squash,
    "inflate": _inflate,
    "spread": _spread,
    "twist": _twist,
    "dent": _dent,
    "wobble": _wobble,
}
