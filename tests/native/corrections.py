# SPDX-License-Identifier: GPL-3.0-or-later
"""The corrections of `preserve` by dense textbook algebra: any number of pins and bodies, all four methods.

One axis (problem 2 with more rows): minimise Σ ω δ² subject to M δ = r, M = [pins; one volume row a body], by the
singular value decomposition. Nothing here knows how the library goes about it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import closings
import numpy as np
from numpy.typing import ArrayLike
from oracle import Array, Embedded, volume

ON = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass
class Solid:
    """Bodies of a mesh in a lattice: x = rows · P + constant, followed by the apexes of the fans that close them."""

    embedded: Embedded
    bodies: list[closings.Faces]
    rows: Array = field(init=False)
    constant: Array = field(init=False)

    def __post_init__(self) -> None:
        apexes: list[list[int]] = []
        self.bodies = [closings.closed(body, apexes, len(self.embedded.rows)) for body in self.bodies]
        self.rows = closings.with_apexes(self.embedded.rows, apexes)
        self.constant = closings.with_apexes(self.embedded.constant, apexes)

    @classmethod
    def of(cls, embedded: Embedded, bodies: list[closings.Faces] | None = None) -> Solid:
        return cls(embedded, [embedded.triangles] if bodies is None else bodies)

    def deform(self, control: Array) -> Array:
        return self.rows @ control.reshape(-1, 3) + self.constant

    def volumes(self, control: Array) -> Array:
        """(bodies,)"""
        points = self.deform(control)
        return np.array([volume(points, body, self.embedded.spec.centre) for body in self.bodies])

    def gradients(self, control: Array) -> Array:
        """(bodies, N, 3) ∂V/∂P, equations (10)-(12) with x, y and z side by side."""
        points = self.deform(control)
        return np.array([self._gradient(points[body], body) for body in self.bodies])

    def _gradient(self, corners: Array, body: closings.Faces) -> Array:
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        at_vertices = np.zeros((len(self.rows), 3))
        np.add.at(at_vertices, body, areas[:, None, :] / 6)
        return self.rows.T @ at_vertices


@dataclass(frozen=True)
class Correction:
    """What is asked of `preserve`. `pin_rows` (m, N) and `pin_places` (m, 3): row · P + rest lands on the place."""

    solid: Solid
    control: Array
    axes: tuple[float, float, float] = (1.0, 1.0, 1.0)
    frame: Array = field(default_factory=lambda: np.array(ON))
    weights: Array | None = None
    pin_rows: Array | None = None
    pin_moves: Array | None = None
    wanted: Array | None = None
    amount: float = 1.0

    @property
    def directions(self) -> Array:
        """Rows of the frame, at unit length."""
        return self.frame / np.linalg.norm(self.frame, axis=1, keepdims=True)

    @property
    def mobility(self) -> Array:
        """(N,) 1/ω."""
        count = self.control.size // 3
        return np.ones(count) if self.weights is None else 1 / np.asarray(self.weights, dtype=float).ravel()

    @property
    def shares(self) -> Array:
        return np.asarray(self.axes, dtype=float) / np.sum(self.axes)

    def moves(self) -> tuple[Array, Array]:
        """Pin rows (m, N), and what each pin has to move along the directions (m, 3)."""
        if self.pin_rows is None or self.pin_moves is None:
            return np.zeros((0, self.control.size // 3)), np.zeros((0, 3))
        return self.pin_rows, self.pin_moves @ np.linalg.inv(self.directions)

    def pinned(self) -> Array:
        """The lattice with the pins alone: the shortest displacement that moves them."""
        rows, moves = self.moves()
        steps = np.stack([shortest(rows, moves[:, axis], self.mobility) for axis in range(3)], axis=1)
        return self.moved(self.control, steps)

    def targets(self) -> Array:
        """(bodies,) V_pins + amount (wanted − V_pins), wanted being the volumes at rest if not given."""
        before = self.solid.volumes(self.pinned())
        wanted = self.solid.volumes(self.solid.embedded.spec.rest) if self.wanted is None else self.wanted
        return before + self.amount * (wanted - before)

    def moved(self, control: Array, steps: Array) -> Array:
        """Control points after (N, 3) steps along the directions."""
        return control + (steps @ self.directions).reshape(control.shape)

    def distance(self, control: ArrayLike) -> float:
        """√Σ ω |δ|² from the lattice given, the lightest weight being 1."""
        moved = np.sum((np.asarray(control) - self.control) ** 2, axis=-1).ravel()
        relative = self.mobility / self.mobility.max()
        free = relative > 0
        return float(np.sqrt(np.sum(moved[free] / relative[free])))

    def sweep(self) -> Array:
        """Each axis adds its share of the difference."""
        return self._axis_by_axis(lambda before, targets, done: before + done * (targets - before))

    def balanced(self) -> Array:
        """Each axis multiplies by its share of the ratio."""
        return self._axis_by_axis(lambda before, targets, done: before * (targets / before) ** done)

    def _axis_by_axis(self, planned) -> Array:
        rows, moves = self.moves()
        control, targets = self.control, self.targets()
        for axis in np.flatnonzero(self.shares == 0):
            control = self._step(control, axis, rows, moves[:, axis])
        before, done = self.solid.volumes(control), 0.0
        for axis in np.flatnonzero(self.shares > 0):
            done += self.shares[axis]
            slopes = self.solid.gradients(control) @ self.directions[axis]
            changes = planned(before, targets, done) - self.solid.volumes(control)
            all_rows, all_moves = np.concatenate([rows, slopes]), np.concatenate([moves[:, axis], changes])
            if self.amount == 0:
                all_rows, all_moves = rows, moves[:, axis]
            control = self._step(control, axis, all_rows, all_moves)
        return control

    def _step(self, control: Array, axis: int, rows: Array, moves: Array) -> Array:
        steps = np.zeros((control.size // 3, 3))
        steps[:, axis] = shortest(rows, moves, self.mobility)
        return self.moved(control, steps)

    def direction(self, control: Array, body: int = 0) -> Array:
        """(N, 3) Ω⁻¹ gradient along the axes that are on, off the pins: method "gradient" moves along it."""
        slopes = self.solid.gradients(control)[body] @ self.directions.T
        steps = self.mobility[:, None] * slopes * (self.shares > 0)
        rows, _ = self.moves()
        return steps - np.stack([shortest(rows, rows @ steps[:, a], self.mobility) for a in range(3)], axis=1)

    def cubic(self) -> tuple[Array, Array]:
        """Of one body: coefficients c_0 … c_3 of V(pinned + t d), and d, at most as long as the lattice is large."""
        pinned = self.pinned()
        along = self.direction(pinned)
        along = along * np.ptp(self.control, axis=(0, 1, 2)).max() / np.abs(along).max()
        times = np.array([-1.0, 0.0, 1.0, 2.0])
        volumes = [self.solid.volumes(self.moved(pinned, t * along))[0] for t in times]
        return np.linalg.solve(np.vander(times, increasing=True), volumes), along

    def first_root(self) -> float | None:
        """t at which V(pinned + t d) is the target, before the cubic turns; None if it turns first."""
        coefficients, _ = self.cubic()
        change = float(self.targets()[0] - coefficients[0])
        if self.amount == 0 or abs(change) <= 1e-14 * abs(coefficients[0]):
            return 0.0
        turns = _real_roots([coefficients[1], 2 * coefficients[2], 3 * coefficients[3]])
        roots = _real_roots([-change, *coefficients[1:]])
        side = np.sign(change * coefficients[1])
        ahead = sorted(abs(t) for t in roots if t * side > 0)
        limit = min((abs(t) for t in turns if t * side > 0), default=np.inf)
        return self._polished(side * ahead[0]) if ahead and ahead[0] <= limit else None

    def _polished(self, t: float) -> float:
        """The root after two of Newton's steps on the volume itself: coefficients of a nearly flat mesh are rough."""
        (coefficients, along), pinned = self.cubic(), self.pinned()
        for _ in range(2):
            slope = coefficients[1] + t * (2 * coefficients[2] + t * 3 * coefficients[3])
            excess = self.solid.volumes(self.moved(pinned, t * along))[0] - self.targets()[0]
            t -= excess / slope if slope else 0.0
        return t

    def gradient(self) -> Array | None:
        """One exact step along the gradient; None where there is no root to go to."""
        root = self.first_root()
        return None if root is None else self.moved(self.pinned(), root * self.cubic()[1])

    def nearest(self, start: Array, rounds: int = 400) -> Array:
        """Fixed point of: the shortest displacement on the constraints as they are linear at the last result."""
        control, targets = start, self.targets()
        for _ in range(rounds):
            linear, wanted = self.linearised(control, targets)
            steps = shortest(linear, wanted, np.tile(self.mobility, 3)).reshape(3, -1).T
            following = self.moved(self.control, steps)
            if np.abs(following - control).max() <= 1e-15 * np.abs(control).max():
                break
            control = following
        return control

    def linearised(self, control: Array, targets: Array) -> tuple[Array, Array]:
        """Rows (3 m + bodies, 3 N) on all three directions at once, linear about `control`, and what they must give."""
        assert np.allclose(self.directions @ self.directions.T, np.eye(3)), "axes of an oblique frame are coupled"
        rows, moves = self.moves()
        pins = np.kron(np.eye(3), rows)
        slopes = (self.solid.gradients(control) @ self.directions.T) * (self.shares > 0)
        slopes = np.moveaxis(slopes, 2, 1).reshape(len(slopes), -1)
        along = ((control - self.control).reshape(-1, 3) @ self.directions.T).T.ravel()
        wanted = targets - self.solid.volumes(control) + slopes @ along
        return np.concatenate([pins, slopes]), np.concatenate([moves.T.ravel(), wanted])

    def stationarity(self, control: Array) -> float:
        """What of Ω^½ δ no multipliers of pins and volumes explain, as a fraction of it: 0 at a KKT point."""
        rows, _ = self.linearised(control, self.targets())
        mobility = np.tile(self.mobility, 3)
        free = mobility > 0
        along = ((control - self.control).reshape(-1, 3) @ self.directions.T).T.ravel()
        moved = along[free] / np.sqrt(mobility[free])
        scaled = unit_rows(rows[:, free] * np.sqrt(mobility[free]))[0]
        left = moved - scaled.T @ np.linalg.lstsq(scaled.T, moved, rcond=None)[0]
        return float(np.linalg.norm(left) / max(np.linalg.norm(moved), 1e-300))

    def with_amount(self, amount: float) -> Correction:
        return replace(self, amount=amount)


def shortest(rows: Array, wanted: Array, mobility: Array) -> Array:
    """argmin Σ δ²/mobility subject to rows · δ = wanted: by least norm, each row first brought to unit length."""
    if len(rows) == 0:
        return np.zeros(len(mobility))
    scaled, lengths = unit_rows(rows * np.sqrt(mobility))
    return np.sqrt(mobility) * np.linalg.lstsq(scaled, wanted / lengths, rcond=1e-14)[0]


def unit_rows(rows: Array) -> tuple[Array, Array]:
    """Rows at unit length, and their lengths (1 for rows of zeros)."""
    lengths = np.linalg.norm(rows, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    return rows / lengths[:, None], lengths


def independence(rows: Array, mobility: Array) -> float:
    """Smallest singular value of the rows at unit length: 0 where one depends on the others."""
    return float(np.linalg.svd(unit_rows(rows * np.sqrt(mobility))[0], compute_uv=False).min(initial=1.0))


def _real_roots(ascending: list[float]) -> list[float]:
    """Real roots of a polynomial, leading coefficients that are nothing but rounding left out."""
    coefficients = np.asarray(ascending, dtype=float)
    sizes = np.abs(coefficients)
    while len(coefficients) > 1 and sizes[len(coefficients) - 1] <= 1e-13 * sizes.max():
        coefficients = coefficients[:-1]
    if len(coefficients) < 2:
        return []
    roots = np.polynomial.polynomial.polyroots(coefficients)
    return [float(r.real) for r in roots if abs(r.imag) <= 1e-9 * max(1.0, abs(r))]
