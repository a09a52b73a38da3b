# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of a mesh keep a volume of their own, where that is not simply the whole of a closed mesh."""

from dataclasses import dataclass, field
from functools import cached_property
from hashlib import blake2b
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import isochor

from .volume import measures

Labels = NDArray[np.int32]
Positions = NDArray[np.floating[Any]]
Triangles = NDArray[np.int32]

IN_REGION = 0.5
"""Weight in the vertex group from which on a vertex is in the region; a triangle is where its three vertices are."""


@dataclass(frozen=True)
class Bodies:
    """``islands``: each closed piece keeps its own; ``close_holes``: holes count as closed; ``region`` (V,): vertices
    of a part that keeps its own, or None."""

    islands: bool
    close_holes: bool
    region: NDArray[np.bool_] | None = field(default=None, repr=False)

    def same_as(self, other: "Bodies | None") -> bool:
        """Whether the two divide a mesh alike."""
        if self is other:
            return True
        return other is not None and self.kind == other.kind and self._shape == other._shape

    @property
    def kind(self) -> str:
        """One letter for each of the three that is on."""
        return "i" * self.islands + "h" * self.close_holes + "r" * (self.region is not None)

    @cached_property
    def _shape(self) -> bytes:
        return b"" if self.region is None else self.region.tobytes()

    def stamp(self, vertices: int) -> str:
        """The kind, the number of vertices and what tells one region from another."""
        region = blake2b(self._shape, digest_size=8).hexdigest() if self._shape else ""
        return f"{self.kind}:{vertices}:{region}"

    def labels(self, positions: Positions, triangles: Triangles | None) -> Literal["islands"] | Labels | None:
        """What ``isochor.Lattice.bind`` takes for bodies; the region is the one with the highest label."""
        if self.region is None or triangles is None:
            return "islands" if self.islands else None
        rest = np.zeros(len(triangles), np.int32)
        if self.islands:
            rest = bound(positions, triangles, "islands", self.close_holes).body_of_triangle
        return with_region(rest, np.asarray(self.region[triangles].all(axis=1)))


def with_region(labels: Labels, inside: NDArray[np.bool_]) -> Labels:
    """The labels (F,), with one more for the triangles ``inside``; counted anew from 0, -1 stays."""
    made = np.where(inside, labels.max(initial=-1) + 1, labels)
    kept = np.unique(made[made >= 0])
    return np.where(made >= 0, np.searchsorted(kept, made), -1).astype(np.int32)


def bound(
    positions: Positions, triangles: Triangles, bodies: Literal["islands"] | Labels | None, close_holes: bool
) -> isochor.Binding:
    """The mesh where it stands, bound to a lattice of no other use."""
    exact = positions.astype(np.float64)
    lattice = isochor.Lattice.around(exact, shape=(2, 2, 2), margin=0.01)
    return lattice.bind(exact, triangles, device="cpu", bodies=bodies, caps=close_holes)


def volumes(positions: Positions, triangles: Triangles, bodies: Bodies | None) -> NDArray[np.float64]:
    """(bodies,) signed volumes, in float64, of the mesh at these positions (V, 3); that of the whole mesh where
    ``bodies`` is None."""
    if bodies is None:
        return np.array([measures(positions, triangles).volume])
    labels = bodies.labels(positions, triangles)
    return bound(positions, triangles, labels, bodies.close_holes).reference_volumes
