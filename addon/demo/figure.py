# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure of the volume paper as a scene: a model whose lattice is keyed, in several variants of the correction, and
what is measured on the mesh that Blender evaluates, in float64 (bpy)."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from gallery_scene import Staged
from gallery_tile import Tile
from numpy.typing import NDArray
from surface_measures import enclosed_volume, mesh_arrays

Array = NDArray[np.float64]
Measures = Callable[[Array, Array], dict[str, float]]
"""Further numbers of a frame, by name, from the vertices (V, 3) of a variant and of the lattice alone."""

Note = Callable[[dict[str, float]], str]
"""Words about the measures."""

HORIZONTAL, VERTICAL, GENERAL = (1.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Variant:
    """One way of correcting, or not: its name, and the inputs of the modifier, with _ for a space."""

    name: str
    inputs: dict[str, Any]

    @property
    def promised(self) -> bool:
        """Whether the volume must be that at rest."""
        return self.inputs["Preserve"] > 0.0


def extents(positions: Array, plain: Array) -> dict[str, float]:
    """Width along x, depth along y and height, in scene units."""
    return dict(zip(("width", "depth", "height"), np.ptp(positions, axis=0).tolist()))


def alone(**inputs: Any) -> Variant:
    """The lattice without any correction."""
    return Variant("lattice alone", {"Preserve": 0.0, **inputs})


def corrected(name: str, axes: tuple[float, float, float], **inputs: Any) -> Variant:
    """The whole volume kept by a correction along these axes."""
    return Variant(name, {"Preserve": 1.0, "Axes": axes, **inputs})


@dataclass(frozen=True)
class FigureRow:
    """One variant in one frame: volumes in scene units, ``plain`` that of the lattice alone."""

    variant: str
    frame: int
    plain: float
    volume: float
    target: float
    promised: bool
    measures: dict[str, float]

    @property
    def plain_change(self) -> float:
        """Of the volume under the lattice alone, relative to that at rest."""
        return self.plain / self.target - 1.0

    @property
    def error(self) -> float:
        """Relative to the target; for the lattice alone what it loses or gains."""
        return abs(self.volume / self.target - 1.0)


@dataclass
class Figure:
    """``variants``: the first is the lattice alone. ``last``: the frame with the whole deformation; 1 is at rest."""

    name: str
    staged: Staged
    variants: tuple[Variant, ...]
    last: int
    measures: Measures = field(default=lambda positions, plain: {})

    def show(self, variant: Variant, frame: int) -> Array:
        """Puts the scene into that state; the vertices (V, 3) that Blender evaluates, float64, in object space."""
        self.staged.put(**variant.inputs)
        bpy.context.scene.frame_set(frame)
        return self.evaluated()[0]

    def evaluated(self) -> tuple[Array, NDArray[np.int32]]:
        """Vertices and triangles as they stand."""
        seen: Any = self.staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        positions, triangles = mesh_arrays(seen.data)
        return positions.astype(np.float64), triangles

    def rows(self, frames: Iterable[int]) -> list[FigureRow]:
        """Every variant measured in these frames."""
        return [row for frame in frames for row in self._frame_rows(frame)]

    def _frame_rows(self, frame: int) -> Iterator[FigureRow]:
        plain, triangles = self.show(self.variants[0], frame), self.evaluated()[1]
        for variant in self.variants:
            found = plain if variant is self.variants[0] else self.show(variant, frame)
            volumes = enclosed_volume(plain, triangles), enclosed_volume(found, triangles)
            numbers = {"moved in z": float(np.abs(found - plain)[:, 2].max()), **self.measures(found, plain)}
            yield FigureRow(variant.name, frame, *volumes, self.staged.whole, variant.promised, numbers)

    def tile(self, variant: Variant, frame: int, caption: str, note: Note | None = None) -> Tile:
        """The picture of that state, the ground as low as the model where that goes down. ``note`` is given the
        measures and says something of them."""
        positions = self.show(variant, frame)
        words = note(self.measures(positions, positions)) if note else ""
        bpy.data.objects["Ground"].location.z = min(0.0, float(positions[:, 2].min()))
        return self.staged.tile(caption, promised=variant.promised, note=words)
