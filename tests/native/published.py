# SPDX-License-Identifier: GPL-3.0-or-later
"""Equations of Hahmann et al. 2012 as they are printed, sums written out: (5), (10)-(12), (17), (21).

Notation of the paper: `P` (N, 3) control points, `B` (V, N) with `B[s, ijk]` = B_ijk(u_s), `faces` (F, 3) with rows
(l, m, n), `alpha` (N,) one of α, β, γ; sums over ijk are sums over the first axis. No weights, no masks.

How (21) must be read: T^x is the target's coordinate, S^x that of the surface point before this axis' step; μ carries
the sign of "+ μ (Σ α δ − a)" in the Lagrangian, hence the minus in δ = λ B/2 − μ α/2; a superscript 2 inside a sum
belongs to the term, one behind a bracket to the sum.
"""

from __future__ import annotations

import numpy as np
from oracle import Array


def volume(x: Array, faces) -> float:
    """Equation (5): Σ (z_l + z_m + z_n)/6 · |x_m − x_l, y_m − y_l; x_n − x_l, y_n − y_l|."""
    corners = x[faces]
    return float(np.sum(corners[:, :, 2].sum(axis=1) / 6 * _determinants(corners, 0, 1)))


def coefficients(x: Array, faces, B: Array, axis: int) -> Array:
    """Equations (10), (11), (12) for axis 0, 1, 2: Σ_faces (B(u_l) + B(u_m) + B(u_n))/6 · |the other two axes|."""
    return B[faces].sum(axis=1).T @ _determinants(x[faces], (axis + 1) % 3, (axis + 2) % 3) / 6


def step_17(alpha: Array, a: float) -> Array:
    """Equation (17): δ = a / Σ α² · α."""
    return a / np.sum(alpha**2) * alpha


def multipliers_21(alpha: Array, B_s: Array, T: float, S: float, a: float) -> tuple[float, float]:
    """λ and μ of equation (21), as printed."""
    below = np.sum(alpha**2) * np.sum(B_s**2) - np.sum(alpha * B_s) ** 2
    lam = (2 * (T - S) * np.sum(alpha**2) - 2 * a * np.sum(alpha * B_s)) / below
    mu = (2 * (T - S) * np.sum(alpha * B_s) - 2 * a * np.sum(B_s**2)) / below
    return lam, mu


def step_21(alpha: Array, B_s: Array, T: float, S: float, a: float) -> Array:
    """Equation (21): δ = λ B_ijk(u_s)/2 − μ α_ijk/2."""
    lam, mu = multipliers_21(alpha, B_s, T, S, a)
    return lam * B_s / 2 - mu * alpha / 2


def problem_1(P: Array, B: Array, faces, reference: float) -> Array:
    """The three steps of section 5.1, each with a = (V_ref − V(M))/3 of the mesh before the first."""
    P, a = P.copy(), (reference - volume(B @ P, faces)) / 3
    for axis in range(3):
        P[:, axis] += step_17(coefficients(B @ P, faces, B, axis), a)
    return P


def problem_2(P: Array, B: Array, faces, reference: float, s: int, T: Array) -> Array:
    """The three steps of section 5.2: vertex s to T, and the volume."""
    P, a = P.copy(), (reference - volume(B @ P, faces)) / 3
    for axis in range(3):
        x = B @ P
        P[:, axis] += step_21(coefficients(x, faces, B, axis), B[s], T[axis], x[s, axis], a)
    return P


def _determinants(corners: Array, first: int, second: int) -> Array:
    """(F,) |first_m − first_l, second_m − second_l; first_n − first_l, second_n − second_l|."""
    m, n = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return m[:, first] * n[:, second] - n[:, first] * m[:, second]
