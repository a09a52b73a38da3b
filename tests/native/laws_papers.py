# SPDX-License-Identifier: GPL-3.0-or-later
"""Free-form deformation as Hoff, Ferrier, Sederberg and the authors of PyGeM print it, written from their texts.

**Hoff** (1997): the names are his. His pseudo-code is right as printed but for one thing: `PtOnSurface` makes `jPts` of
length O and `kPts` of length N, and calls them the other way round in its comments. Right- or left-handed axes are
both allowed.

**Ferrier**: listing 3, `EvalVolume`, must be read with two corrections. Its innermost statement,
`Ret += P[i][j] * (BU[i] * BV[j])`, is that of listing 2: in a volume it must be
`Ret += P[i][j][k] * (BU[i] * BV[j] * BW[k])`, or every layer k adds the same array of vectors and BW is never used.
And one closing brace of the three loops is missing. Equation 7, whose picture is lost, is that triple sum.

**Sederberg** (14.1)-(14.3): below the fraction bar of (14.1) stands the same sum without the points. The text after it
names the functions B_i^n(t) and B_j^m(s); the equation's own B_i^m(s) and B_j^n(t) are meant.

**PyGeM** (its documentation of `FFD`): M = ψ⁻¹ ∘ T̂ ∘ ψ with ψ the affine map of the box onto the unit cube and
T̂(x) = Σ b_l(x) b_m(y) b_n(z) (P_lmn + μ_lmn), the weights μ being displacements in units of the box's lengths.
Points outside the box are not moved.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from oracle import Array


def hoff_lattice(centre, axes, half_dims, intervals) -> tuple[Array, Array]:
    """LatticeOrigin (3,) and LatticeCtrlPts (NumIntX + 1, NumIntY + 1, NumIntZ + 1, 3), by stepping."""
    (x, y, z), (half_x, half_y, half_z) = np.asarray(axes, dtype=float), half_dims
    origin = np.asarray(centre, dtype=float) - x * half_x - y * half_y - z * half_z
    step_x, step_y, step_z = (axis * (2 * half) / n for axis, half, n in zip((x, y, z), half_dims, intervals))
    points = np.zeros((*(n + 1 for n in intervals), 3))
    temp_x = origin.copy()
    for i in range(intervals[0] + 1):
        temp_y = temp_x.copy()
        for j in range(intervals[1] + 1):
            temp_z = temp_y.copy()
            for k in range(intervals[2] + 1):
                points[i, j, k] = temp_z
                temp_z += step_z
            temp_y += step_y
        temp_x += step_x
    return origin, points


def hoff_stu(point, origin, axes, half_dims) -> Array:
    """(s, t, u) of a point in the world, by projection onto the axes."""
    xyz = np.asarray(point, dtype=float) - origin
    return np.array([xyz @ axis / (2 * half) for axis, half in zip(np.asarray(axes, dtype=float), half_dims)])


def pt_on_curve(t: float, pts: ArrayLike) -> Array:
    """De Casteljau, on a copy of the points (n, 3)."""
    pts = np.array(pts, dtype=float)
    for i in range(len(pts) - 1, 0, -1):
        for j in range(i):
            pts[j] = pts[j] + (pts[j + 1] - pts[j]) * t
    return pts[0]


def pt_on_surface(t: float, u: float, pts: Array) -> Array:
    """Points (n, o, 3): along u first."""
    return pt_on_curve(t, [pt_on_curve(u, row) for row in pts])


def pt_in_lattice(s: float, t: float, u: float, pts: Array) -> Array:
    """Points (n, m, o, 3)."""
    return pt_on_curve(s, [pt_on_surface(t, u, section) for section in pts])


def ferrier_basis(u: float) -> list[float]:
    """B[0] … B[3] of listing 1."""
    return [
        (1.0 - u) * (1.0 - u) * (1.0 - u),
        3.0 * u * (1 - u) * (1.0 - u),
        3.0 * u * u * (1.0 - u),
        u * u * u,
    ]


def eval_curve(P: Array, u: float) -> Array:
    """Listing 1."""
    B = ferrier_basis(u)
    ret = np.zeros(3)
    for i in range(4):
        ret += P[i] * B[i]
    return ret


def eval_surface(P: Array, u: float, v: float) -> Array:
    """Listing 2."""
    BU, BV = ferrier_basis(u), ferrier_basis(v)
    ret = np.zeros(3)
    for i in range(4):
        for j in range(4):
            ret += P[i][j] * (BU[i] * BV[j])
    return ret


def eval_volume(P: Array, u: float, v: float, w: float) -> Array:
    """Listing 3 as it must be read."""
    BU, BV, BW = ferrier_basis(u), ferrier_basis(v), ferrier_basis(w)
    ret = np.zeros(3)
    for i in range(4):
        for j in range(4):
            for k in range(4):
                ret += P[i][j][k] * (BU[i] * BV[j] * BW[k])
    return ret


def eval_volume_as_printed(P: Array, u: float, v: float, w: float) -> Array:
    """Listing 3 letter by letter, as far as it has a meaning: one layer of points, added four times, and w unused."""
    return 4 * eval_surface(P[:, :, 0], u, v)


def sederberg_grid(low, high, m: int, n: int) -> Array:
    """(14.3): (m + 1, n + 1, 2) undisplaced control points."""
    (x_min, y_min), (x_max, y_max) = low, high
    return np.array(
        [
            [(x_min + i / m * (x_max - x_min), y_min + j / n * (y_max - y_min)) for j in range(n + 1)]
            for i in range(m + 1)
        ]
    )


def sederberg_local(point, low, high) -> tuple[float, float]:
    """(14.2)."""
    (x, y), (x_min, y_min), (x_max, y_max) = point, low, high
    return (x - x_min) / (x_max - x_min), (y - y_min) / (y_max - y_min)


def sederberg_blend(P: Array, w: Array, s: float, t: float) -> Array:
    """(14.1)."""
    m, n = P.shape[0] - 1, P.shape[1] - 1
    above, below = np.zeros(2), 0.0
    for j in range(n + 1):
        for i in range(m + 1):
            value = w[i, j] * _bernstein(m, i, s) * _bernstein(n, j, t)
            above, below = above + value * P[i, j], below + value
    return above / below


def sederberg_moved(point, P: Array, w: Array, low, high) -> Array:
    """The last paragraph: within [0, 1] repositioned by (14.1), otherwise not moved."""
    s, t = sederberg_local(point, low, high)
    return sederberg_blend(P, w, s, t) if 0 <= s <= 1 and 0 <= t <= 1 else np.asarray(point, dtype=float)


def pygem_moved(points: ArrayLike, origin, lengths, turn: Array, mu: Array) -> Array:
    """(V, 3) points: box at `origin` with sides along the rows of `turn`, weights mu (n, m, o, 3) in box lengths."""
    points = np.asarray(points, dtype=float)
    local = (points - origin) @ np.linalg.inv(turn * np.asarray(lengths, dtype=float)[:, None])
    inside = np.all((local >= 0) & (local <= 1), axis=1)
    b = [
        np.array([[_bernstein(n - 1, i, x) for i in range(n)] for x in local[:, axis]])
        for axis, n in enumerate(mu.shape[:3])
    ]
    shift = np.einsum("vl,vm,vn,lmnx->vx", *b, mu) @ (turn * np.asarray(lengths, dtype=float)[:, None])
    return np.where(inside[:, None], points + shift, points)


def _bernstein(n: int, i: int, t: float) -> float:
    return math.factorial(n) // (math.factorial(i) * math.factorial(n - i)) * t**i * (1 - t) ** (n - i)
