# SPDX-License-Identifier: GPL-3.0-or-later
"""All that one frame of one modifier asks of the solver."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import same_array
from .bodies import Bodies
from .bound import Embedding
from .grid import Grid
from .pins import Pins, same_pins
from .settings import Settings

Vertices = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Request:
    """One frame of one modifier, in the deformed object's own space.

    ``positions`` (V, 3) float32; ``influence`` (V,) float32 in [0, 1] or None for 1 everywhere; ``triangles`` (F, 3)
    int32, the very same array as in the frame before where the faces have not changed, or None with the reason in
    ``no_triangles``, which is empty for curves and points alone; ``control`` (nu, nv, nw, 3) float64; ``frame`` (3, 3)
    rows or None; ``rest_volume`` is the volume that entered when the modifier was added or bound, or None where that is
    not known; ``incoming`` the volume of each body in this frame that counts where Reference is Incoming, None for that
    of ``positions``. ``device`` is what should compute: "auto", "gpu", "cpu" or the name of an adapter; ``double``
    whether in float64 up to the last rounding. ``bound``: the lattice when its rest was set, from which ``control``
    then moves the vertices; None where ``grid``, the lattice as it stands, embeds them. ``bodies``: which parts keep a
    volume of their own, or None for one volume of all, and ``rest_parts`` those volumes when they were first asked for.
    ``stiffness`` (nu, nv, nw) in [0, 1], or None for 0 everywhere. ``pins``: points that must land on targets, or None.
    """

    positions: Vertices = field(repr=False)
    influence: NDArray[np.float32] | None = field(repr=False)
    triangles: NDArray[np.int32] | None = field(repr=False)
    no_triangles: str
    grid: Grid
    control: NDArray[np.float64] = field(repr=False)
    frame: NDArray[np.float64] | None
    rest_volume: float | None
    settings: Settings
    device: str = "auto"
    double: bool = False
    bound: Embedding | None = None
    bodies: Bodies | None = None
    rest_parts: tuple[float, ...] | None = None
    stiffness: NDArray[np.float64] | None = field(default=None, repr=False)
    pins: Pins | None = None
    incoming: tuple[float, ...] | None = None

    @property
    def has_surface(self) -> bool:
        """Whether there are faces, known or not."""
        return self.triangles is not None or bool(self.no_triangles)

    @property
    def embedding_grid(self) -> Grid:
        """The undeformed lattice that the vertices are embedded in."""
        return self.grid if self.bound is None else self.bound.grid

    @property
    def rest_control(self) -> NDArray[np.float64] | None:
        """Control points that move nothing; None for those of the undeformed lattice."""
        return None if self.bound is None else self.bound.control

    def same_as(self, other: "Request | None") -> bool:
        """Whether the two ask for the same thing, so that the answer is known."""
        return (
            other is not None
            and self.triangles is other.triangles
            and (self.no_triangles, self.rest_volume, self.settings, self.device, self.double)
            == (other.no_triangles, other.rest_volume, other.settings, other.device, other.double)
            and self.divides_as(other)
            and (self.rest_parts, self.incoming) == (other.rest_parts, other.incoming)
            and self.grid.same_as(other.grid)
            and self.embeds_as(other)
            and np.array_equal(self.control, other.control)
            and same_array(self.frame, other.frame)
            and same_array(self.influence, other.influence)
            and same_array(self.stiffness, other.stiffness)
            and same_array(self.positions, other.positions)
            and same_pins(self.pins, other.pins)
        )

    def embeds_as(self, other: "Request") -> bool:
        """Whether the two embed a vertex alike."""
        return (self.bound is not None and self.bound is other.bound) or (
            self.embedding_grid.same_as(other.embedding_grid) and same_array(self.rest_control, other.rest_control)
        )

    def divides_as(self, other: "Request") -> bool:
        """Whether the same parts of the mesh keep a volume of their own in both."""
        return self.bodies is other.bodies or (self.bodies is not None and self.bodies.same_as(other.bodies))
