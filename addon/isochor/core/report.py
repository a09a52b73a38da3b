# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that one computed frame of one modifier tells; the costly ones are worked out when first asked for."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import isochor

from . import problem
from .bodies import Bodies, volumes
from .bound import Embedding
from .grid import Grid
from .pins import Pins


class Volumes(NamedTuple):
    """Signed volumes in cubic units of the object's own space: ``before`` the correction, as the animator's lattice
    deforms the mesh, and ``after`` it, each of all ``bodies`` that keep one together. ``error`` is
    |after - target| / |target| of the body where that is largest."""

    target: float
    before: float
    after: float
    error: float
    bodies: int = 1


@dataclass
class Report:
    """Lengths in units of the object's own space, time in milliseconds. ``grid`` is the lattice as it stands, and also
    what vertices are embedded in unless ``bound``, the lattice when its rest was set, is there. ``result`` is there
    where the lattice was corrected: ``keeps_volume`` says whether for the volume too, or for the pins alone."""

    problems: tuple[str, ...] = ()
    binding: isochor.Binding | None = field(default=None, repr=False)
    grid: Grid | None = field(default=None, repr=False)
    bound: Embedding | None = field(default=None, repr=False)
    asked: NDArray[np.float64] | None = field(default=None, repr=False)
    held: NDArray[np.float64] | None = field(default=None, repr=False)
    """The control points asked for, those of layers that a joint freezes at rest; None where there is none."""
    result: isochor.Preserved | None = field(default=None, repr=False)
    keeps_volume: bool = False
    has_surface: bool = True
    """Whether there are faces at all, not curves and points alone."""
    pins: Pins | None = field(default=None, repr=False)
    milliseconds: float = 0.0
    embed: Callable[[], isochor.Binding] | None = field(default=None, repr=False)
    """Puts the mesh of this frame back into the binding, which other frames may have used since."""
    rounded: tuple[NDArray[Any], NDArray[np.int32], Bodies | None] | None = field(default=None, repr=False)
    """Vertices that the user gets, their triangles and bodies, where ``result`` holds them in more digits."""
    method: str = ""
    """The method asked for, by its name in ``settings.METHODS``."""

    @property
    def control(self) -> NDArray[np.float64] | None:
        """(nu, nv, nw, 3) control points that shaped the mesh, corrected where it was, in the object's own space."""
        if self.result is not None:
            return np.asarray(self.result.control)
        return self.asked if self.held is None else self.held

    @property
    def vertices(self) -> NDArray[Any] | None:
        """(V, 3) vertices that the user gets; None where the lattice was not corrected."""
        if self.rounded is not None:
            return self.rounded[0]
        return None if self.result is None else self.result.vertices

    @property
    def device(self) -> str:
        """What computed the correction; empty where there was none."""
        return str(self.result.device) if self.result is not None else ""

    @property
    def device_name(self) -> str:
        """The same by its own name."""
        return self.binding.device_name if self.device == "gpu" and self.binding is not None else self.device

    @property
    def embedded(self) -> isochor.Binding | None:
        """The binding, with the mesh of this frame in it."""
        return self.binding if self.binding is None or self.embed is None else self.embed()

    @cached_property
    def volumes(self) -> Volumes | None:
        """None where no volume was corrected."""
        binding, result = self.embedded, self.result
        if binding is None or result is None or self.asked is None or not self.keeps_volume:
            return None
        targets = np.asarray(result.targets)
        after = np.asarray(result.volumes) if self.rounded is None else volumes(*self.rounded)
        before = binding.volume(self.asked)
        # A target of nothing has no size to compare with: the others', or what there was before, stands in.
        sizes = np.where(targets == 0.0, max(np.abs(targets).max(), abs(before)), np.abs(targets))
        error = float((np.abs(after - targets) / sizes).max())
        return Volumes(result.target, before, float(after.sum()), error, len(targets))

    @property
    def missing(self) -> float:
        """Volume that the correction left out so that it would fold nothing over."""
        return 0.0 if self.result is None else float(self.result.missing)

    @property
    def notes(self) -> list[str]:
        """What is not wrong, and yet perhaps not what the animator believes, in plain words."""
        result = self.result
        if not self.has_surface:
            return [problem.NO_SURFACE]
        if result is None or not self.keeps_volume:
            return []
        found: list[str] = [problem.INSIDE_OUT] if self.inside_out else []
        if result.method != self.method.lower():
            found.append(problem.fell_back(self.method, str(result.method).capitalize()))
        if self.missing:
            found.append(problem.would_fold(self.missing, self.missing / result.target))
        return found

    @cached_property
    def largest_miss(self) -> float | None:
        """How far the pin that misses its target most is from it, in world units; None where none was held."""
        if self.pins is None or self.vertices is None:
            return None
        return float(self.pins.misses(self.vertices).max())

    @cached_property
    def largest_displacement(self) -> float | None:
        """How far the correction moved the control point that it moved most."""
        if self.result is None or self.asked is None:
            return None
        return float(np.linalg.norm(self.result.control - self.asked, axis=-1).max())

    @cached_property
    def vertices_outside(self) -> int | None:
        """How many vertices stand outside the lattice's domain, or of a bound one outside its shape."""
        return None if self.embedded is None else self.embedded.outside_count

    @cached_property
    def inside_out(self) -> bool:
        """Whether the faces point inwards, so that the volume counts as negative."""
        return self.result is not None and self.keeps_volume and bool((np.asarray(self.result.targets) < 0.0).any())
