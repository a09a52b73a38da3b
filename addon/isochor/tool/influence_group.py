# SPDX-License-Identifier: GPL-3.0-or-later
"""The vertex group that tells Blender's own Lattice modifier how much of the deformation each vertex takes.

With Outside at Keep ours leaves vertices outside the lattice where they are; Blender's moves them, unless a group says
not to.
"""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.settings import Settings

NAME = "Volume Lattice Inside"
"""What a group made here is called, if the name is free."""


def of(obj: bpy.types.Object, settings: Settings, inside: NDArray[np.bool_] | None) -> tuple[str, bool]:
    """Name of the group, empty where everything moves in full, and whether to invert it: the animator's, or where only
    the vertices ``inside`` (V,) move, a new one."""
    named = settings.vertex_group if settings.vertex_group in obj.vertex_groups else ""
    if inside is None:
        return named, bool(named) and settings.invert
    weights = np.ones(len(inside)) if not named else _weights(obj, named, settings.invert)
    return _new_group(obj, np.where(inside, weights, 0.0)), False


def remove(obj: bpy.types.Object, name: str) -> None:
    """Takes the group away if it was made here."""
    if name.startswith(NAME) and name in obj.vertex_groups:
        obj.vertex_groups.remove(obj.vertex_groups[name])


def _weights(obj: bpy.types.Object, name: str, invert: bool) -> NDArray[np.float64]:
    index = obj.vertex_groups[name].index
    found = np.zeros(len(obj.data.vertices))
    for vertex in obj.data.vertices:
        found[vertex.index] = next((entry.weight for entry in vertex.groups if entry.group == index), 0.0)
    return 1.0 - found if invert else found


def _new_group(obj: bpy.types.Object, weights: NDArray[np.float64]) -> str:
    group = obj.vertex_groups.new(name=NAME)
    for weight in np.unique(weights[weights > 0.0]):
        group.add(np.flatnonzero(weights == weight).tolist(), float(weight), "REPLACE")
    return str(group.name)
