# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the lattice of a report folds over, and where: worked out when it is to be shown, once for each shape."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import isochor

from .bound import Embedding
from .grid import Grid, build_lattice
from .report import Report

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Shape:
    """All that decides about folds: what vertices are embedded in, and the control points that then move them."""

    grid: Grid
    bound: Embedding | None = field(repr=False)
    control: Array = field(repr=False)

    def same_as(self, other: "_Shape") -> bool:
        """Whether the two hold the same numbers."""
        if self.bound is not other.bound or not np.array_equal(self.control, other.control):
            return False
        return self.bound is not None or self.grid.same_as(other.grid)


@dataclass
class Folding:
    """What is known of the shape last asked for."""

    _shape: _Shape | None = None
    _found: isochor.Folds | None = None

    def of(self, report: Report, compute: bool = True) -> isochor.Folds | None:
        """Folds of the lattice as it shaped the mesh, corrected where it was, in the object's own space; the very same
        object for the same shape. None where there is no lattice, and with ``compute`` off where they are not known.
        """
        shape = _shape_of(report)
        if shape is None:
            return None
        if self._shape is None or not shape.same_as(self._shape):
            if not compute:
                return None
            self._shape, self._found = shape, _folds(shape)
        return self._found


def _shape_of(report: Report) -> _Shape | None:
    if report.grid is None or report.control is None:
        return None
    return _Shape(report.grid, report.bound, report.control)


def _folds(shape: _Shape) -> isochor.Folds | None:
    """None where the numbers are no shape at all, which the report's problems say."""
    bound = shape.bound
    try:
        if bound is None:
            return build_lattice(shape.grid).folds(shape.control)
        return build_lattice(bound.grid).folds(shape.control, rest=bound.control)
    except isochor.Error:
        return None
