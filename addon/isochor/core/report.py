# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that one computed frame of one modifier tells; the costly ones are worked out when first asked for."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import isochor


@dataclass
class Report:
    """Volumes in cubic units of the object's own space, lengths in its units, time in milliseconds."""

    problems: tuple[str, ...] = ()
    binding: isochor.Binding | None = field(default=None, repr=False)
    asked: NDArray[np.float64] | None = field(default=None, repr=False)
    result: isochor.Preserved | None = field(default=None, repr=False)
    milliseconds: float = 0.0

    @property
    def device(self) -> str:
        """What computed the correction; empty where there was none."""
        return str(self.result.device) if self.result is not None else ""

    @cached_property
    def volume_before(self) -> float | None:
        """Of the mesh as the animator's lattice deforms it; None where it has no volume."""
        if self.binding is None or self.result is None:
            return None
        return self.binding.volume(self.asked)

    @cached_property
    def volume(self) -> float | None:
        """Of the corrected mesh, signed."""
        return self.result.volume if self.result is not None else None

    @cached_property
    def target(self) -> float | None:
        """The volume that was to be reached, signed."""
        return self.result.target if self.result is not None else None

    @cached_property
    def error(self) -> float | None:
        """|volume - target| / |target| on the deformed vertices."""
        return self.result.error if self.result is not None else None

    @cached_property
    def largest_displacement(self) -> float | None:
        """How far the correction moved the control point that it moved most."""
        if self.result is None or self.asked is None:
            return None
        return float(np.linalg.norm(self.result.control - self.asked, axis=-1).max())

    @cached_property
    def vertices_outside(self) -> int | None:
        """How many vertices stand outside the lattice's domain."""
        return self.binding.outside_count if self.binding is not None else None

    @cached_property
    def inside_out(self) -> bool:
        """Whether the faces point inwards, so that the volume counts as negative."""
        return self.target is not None and self.target < 0.0
