# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of the surface that must land on targets: what the native library is told, and what it says of them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import isochor

from . import barycentric
from .arrays import same_array

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pins:
    """``names`` (m,) of the objects that hold them, for what is said; ``corners`` (m, 3) vertices with ``weights``
    (m, 3), a vertex being its own three corners; ``targets`` (m, 3) in the deformed object's own space. ``triangles``
    (m,) where those corners are a triangle, or None where all are vertices. ``metric`` (3, 3) turns a way in the
    object's space into one of the length that it has in the world."""

    names: tuple[str, ...]
    corners: NDArray[np.int32] = field(repr=False)
    weights: Array = field(repr=False)
    triangles: NDArray[np.int64] | None = field(repr=False)
    targets: Array
    metric: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.names)

    def same_as(self, other: "Pins | None") -> bool:
        """Whether the two ask for the same thing in the same words."""
        return (
            other is not None
            and self.names == other.names
            and np.array_equal(self.corners, other.corners)
            and np.array_equal(self.weights, other.weights)
            and same_array(self.triangles, other.triangles)
            and np.array_equal(self.targets, other.targets)
            and np.array_equal(self.metric, other.metric)
        )

    def for_native(self) -> isochor.Pins:
        """The same as the native library takes them."""
        if self.triangles is None:
            return isochor.Pins(self.corners[:, 0], self.targets)
        return isochor.Pins(self.triangles, self.targets, self.weights)

    def places(self, vertices: NDArray[np.floating[Any]]) -> Array:
        """(m, 3) where the pinned points are among these vertices (V, 3)."""
        return barycentric.places(vertices, self.corners, self.weights)

    def misses(self, vertices: NDArray[np.floating[Any]]) -> Array:
        """(m,) how far the pinned points are from their targets, in world units."""
        ways = (self.places(vertices) - self.targets) @ self.metric.T
        return np.asarray(np.linalg.norm(ways, axis=1))

    def fading_weights(
        self, lattice: isochor.Lattice, positions: NDArray[Any], rest: Array | None, distance: float
    ) -> Array:
        """(nu, nv, nw) weights of the control points that grow by the factor e with each ``distance`` (world units)
        from the nearest pin, so that the correction stays about the pins (the paper's figure 7). Measured where nothing
        is deformed: from the vertices that entered, ``positions``, to the control points at rest (None: the lattice's
        own)."""
        control = np.asarray(lattice.rest if rest is None else rest, np.float64)
        points = self.places(positions) @ self.metric.T
        return np.asarray(lattice.falloff(points, distance, control=control @ self.metric.T))


def same_pins(one: Pins | None, other: Pins | None) -> bool:
    """Whether the two ask for the same thing, or both for nothing."""
    return other is None if one is None else one.same_as(other)
