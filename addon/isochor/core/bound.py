# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice as it stood when its rest was set: from then on its shape and place are measured from there."""

from dataclasses import dataclass, field
from functools import cached_property
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from . import problem
from .blending import Blending
from .grid import Grid, build_lattice, control_points
from .volume import SINGLE

Array = NDArray[np.float64]

FLAT = 1e-6
"""Thickness of a lattice, as a fraction of its largest extent, below which nothing can be inside."""


@dataclass(frozen=True)
class Embedding:
    """Where vertices are embedded: the undeformed ``grid`` of the lattice and its ``control`` points (nu, nv, nw, 3) at
    rest, both in the deformed object's space and as they stood when the rest was set."""

    grid: Grid
    control: Array = field(repr=False)

    @cached_property
    def is_shaped(self) -> bool:
        """Whether the lattice was shaped, by more than the rounding of Blender's coordinates."""
        undeformed = build_lattice(self.grid).rest
        rounding = 4.0 * SINGLE * float(np.abs(undeformed).max())
        return float(np.abs(self.control - undeformed).max()) > rounding


@dataclass(frozen=True)
class BoundShape:
    """What is kept of a lattice: resolution, first and last undeformed point and ``points`` (flat xyz, u fastest), in
    the lattice's own space; the way from there ``to_object``, the deformed object's space (4x4); the lattice's name."""

    lattice: str
    shape: tuple[int, int, int]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    to_object: Array
    points: NDArray[np.float32] = field(repr=False)

    def embedding(self, blending: Blending) -> Embedding:
        """Where control points blend like that."""
        how = blending.basis, self.to_object, blending.interpolation, blending.weights
        grid = Grid(self.shape, self.low, self.high, *how)
        return Embedding(grid, control_points(grid, self.points))

    @property
    def stamp(self) -> str:
        """The same for the same numbers, and for no others."""
        numbers = np.array([*self.shape, *self.low, *self.high, *self.to_object.ravel()], np.float64)
        return blake2b(numbers.tobytes() + self.points.tobytes(), digest_size=12).hexdigest()

    def refuse_flat(self) -> None:
        """Raises a Problem where the points, in object space, leave no room inside."""
        extents = np.array(self.shape) > 1
        points = self.embedding(Blending("Bernstein")).control.reshape(-1, 3)
        sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if extents.any() and sizes[extents.sum() - 1] <= FLAT * sizes[0]:
            raise problem.Problem(problem.flat_shape(self.lattice))

    def refuse_other(self, name: str, shape: tuple[int, int, int]) -> None:
        """Raises a Problem where the lattice, now called ``name``, has another resolution."""
        if shape != self.shape:
            raise problem.Problem(problem.bound_otherwise(self.shape, name, shape))
