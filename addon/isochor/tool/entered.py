# SPDX-License-Identifier: GPL-3.0-or-later
"""The points that entered one modifier, of whatever kinds, as its node group stored them on what was evaluated."""

from functools import cached_property
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import evaluated, incoming_nodes, own_points, stack

Floats = NDArray[np.float32]


class Entered:
    """Of one evaluated object: vertices, then control points of curves, each handle of all of them where some are
    Bézier curves, then points of a cloud; as the module ``other_points`` lays them out."""

    def __init__(self, obj_evaluated: bpy.types.Object, slot: str, followed: bool) -> None:
        """``slot`` of the modifier; ``followed``: whether modifiers come after it that may lose or move points."""
        self._obj, self._slot, self._followed = obj_evaluated, slot, followed

    @cached_property
    def positions(self) -> Floats | None:
        """(P, 3), or None where what came after has lost some or moved them about."""
        found = [self._positions(data) for data in self._pieces]
        known = [part for part in found if part is not None]
        return np.concatenate(known) if known and len(known) == len(found) else None

    @property
    def is_empty(self) -> bool:
        """Whether there are no points at all, so that none can have been lost."""
        return not any(map(evaluated.point_count, self._held[1]))

    @property
    def mesh(self) -> bpy.types.Mesh | None:
        """The evaluated mesh, if vertices are among what entered."""
        return next((data for data in self._pieces if isinstance(data, bpy.types.Mesh)), None)

    @property
    def others(self) -> int:
        """Points that are not vertices, behind these."""
        return sum(self._size(data) for data in self._pieces if not isinstance(data, bpy.types.Mesh))

    def numbers(self, prefix: str) -> Floats | None:
        """(P,) of an attribute that the group stores where it is asked to; a handle's is that of its point."""
        parts = []
        for data in self._pieces:
            values = self._read(data, prefix, "value", 1)
            if values is None:
                return None
            parts.append(np.tile(values[: self._count(data)], len(self._vectors(data))))
        return np.concatenate(parts) if parts else None

    def has_group(self, obj: bpy.types.Object, name: str) -> bool:
        """Whether the vertex group is there; of what has none, an attribute of that name."""
        if obj.type == "MESH":
            return name in obj.vertex_groups
        return any(name in data.attributes for data in self._pieces)

    @cached_property
    def _held(self) -> tuple[Any, list[bpy.types.ID]]:
        if self._obj.type == "MESH" and not any(map(_is_other_group, self._obj.modifiers)):
            return None, [self._obj.data]
        return own_points.pieces(self._obj)

    @cached_property
    def _pieces(self) -> list[bpy.types.ID]:
        """Those that carry what entered."""
        name = incoming_nodes.INCOMING + self._slot
        return [data for data in self._held[1] if name in data.attributes and len(data.attributes[name].data)]

    def _positions(self, data: bpy.types.ID) -> Floats | None:
        parts = [self._read(data, prefix, "vector", 3) for prefix in self._vectors(data)]
        count = self._count(data)
        known = [part.reshape(-1, 3)[:count] for part in parts if part is not None]
        if count == 0 or len(known) < len(parts):
            return None
        return known[0] if len(known) == 1 else np.concatenate(known)

    def _vectors(self, data: bpy.types.ID) -> tuple[str, ...]:
        """What holds positions of its points."""
        if isinstance(data, bpy.types.Curves) and incoming_nodes.LEFT + self._slot in data.attributes:
            return incoming_nodes.INCOMING, incoming_nodes.LEFT, incoming_nodes.RIGHT
        return (incoming_nodes.INCOMING,)

    def _size(self, data: bpy.types.ID) -> int:
        return self._count(data) * len(self._vectors(data))

    def _count(self, data: bpy.types.ID) -> int:
        """Points of a kind that entered; 0 where that cannot be told."""
        if not self._followed:
            return evaluated.point_count(data)
        return evaluated.incoming_count(data, incoming_nodes.ORDER + self._slot) or 0

    def _read(self, data: bpy.types.ID, prefix: str, field_name: str, width: int) -> NDArray[Any] | None:
        return evaluated.attribute(data, prefix + self._slot, field_name, width, np.float32)


def _is_other_group(modifier: bpy.types.Modifier) -> bool:
    """Whether the modifier may make points that are not vertices of a mesh."""
    return modifier.type == "NODES" and not stack.is_ours(modifier)
