# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading what Blender evaluated: the mesh that entered a modifier, its faces, the lattice's points."""

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.faces import split_small_faces
from ..core.quads import quads_of

Positions = NDArray[np.float32]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def matrix(obj: bpy.types.Object) -> NDArray[np.float64]:
    """Object to world, 4x4."""
    return np.array(obj.matrix_world, dtype=np.float64)


def attribute(
    data: bpy.types.ID, name: str, field_name: str, width: int, dtype: type[np.generic]
) -> NDArray[Any] | None:
    """Values of a point attribute of a mesh, curves or a cloud, flat, or None where these do not have it in full."""
    found = data.attributes.get(name)
    if found is None or found.domain != "POINT" or len(found.data) != point_count(data):
        return None
    values: NDArray[Any] = np.empty(len(found.data) * width, dtype)
    found.data.foreach_get(field_name, values)
    return values


def point_count(data: bpy.types.ID) -> int:
    """Vertices of a mesh, points of anything else."""
    return len(data.vertices if isinstance(data, bpy.types.Mesh) else data.points)


def incoming_count(data: bpy.types.ID, order_name: str) -> int | None:
    """How many points entered, or None where the modifiers that followed lost or moved some of them.

    The attribute counts down from that number to one over the points that entered; what was made later comes after.
    """
    order = attribute(data, order_name, "value", 1, np.int32)
    if order is None or len(order) == 0:
        return None
    count = int(order[0])
    intact = 0 < count <= len(order) and np.array_equal(order[:count], np.arange(count, 0, -1, dtype=np.int32))
    return count if intact else None


@dataclass(frozen=True)
class LatticePoints:
    """Resolution, first and last undeformed point, and deformed points (flat, u fastest), all in lattice space."""

    shape: tuple[int, int, int]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    deformed: Positions

    @property
    def box(self) -> Box:
        """First and last undeformed point."""
        return self.low, self.high


UNIT_BOX = ((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
"""Where Blender puts the undeformed points of a lattice that an object has."""


def lattice_points(lattice: bpy.types.Object, known_box: Box = UNIT_BOX) -> LatticePoints:
    """What an evaluated lattice object holds. In the lattice's edit mode Blender cannot tell the undeformed points:
    then the box is ``known_box``."""
    data = lattice.data
    shape = (data.points_u, data.points_v, data.points_w)
    count = len(data.points)
    if count != shape[0] * shape[1] * shape[2]:
        raise problem.Problem(problem.capped_lattice(lattice.name, shape, count))
    points = np.empty(count * 3, np.float32)
    data.points.foreach_get("co_deform", points)
    box = known_box if data.is_editmode else (tuple(data.points[0].co), tuple(data.points[-1].co))
    return LatticePoints(shape, *box, points)


@dataclass
class Faces:
    """Triangles of the mesh that entered, kept as long as its faces stay the same."""

    triangles: NDArray[np.int32] | None = field(default=None, repr=False)
    _stamp: object = None
    _corners: NDArray[np.int32] | None = field(default=None, repr=False)
    _starts: NDArray[np.int32] | None = field(default=None, repr=False)

    def read(
        self, mesh: bpy.types.Mesh, original: bpy.types.Mesh | None, count: int, stamp: object | None
    ) -> NDArray[np.int32] | None:
        """(F, 3) vertex indices, the very same array as long as the faces are the same; None where they cannot be
        read, because modifiers before and after ours both change them.

        ``mesh`` is evaluated, ``original`` the object's own, of a text or a curve None; ``count`` vertices entered.
        Faces are read and compared only where ``stamp``, which with the counts tells all that they can depend on,
        differs from the last time or is None (unknown): Blender copies whole arrays to let Python see them.
        """
        source = mesh if len(mesh.vertices) == count else original
        if source is None or len(source.vertices) != count:
            self.triangles, self._stamp = None, None
            return None
        whole = None if stamp is None else (stamp, count, len(source.loops), len(source.polygons))
        if whole is None or whole != self._stamp:
            self._refresh(source, original)
            self._stamp = whole
        return self.triangles

    def quads(self) -> NDArray[np.int32]:
        """(Q, 4) vertices of the faces with four corners among those that were read."""
        if self._corners is None or self._starts is None:
            return np.empty((0, 4), np.int32)
        return quads_of(self._corners, self._starts)

    def _refresh(self, source: bpy.types.Mesh, original: bpy.types.Mesh | None) -> None:
        corners, starts = face_arrays(source)
        if self.triangles is not None and same(corners, self._corners) and same(starts, self._starts):
            return
        self._corners, self._starts = corners, starts
        self.triangles = triangulate(source, original, corners, starts)


def face_arrays(mesh: bpy.types.Mesh) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Vertex of each corner, and first corner of each face."""
    corners = np.empty(len(mesh.loops), np.int32)
    starts = np.empty(len(mesh.polygons), np.int32)
    if len(corners):
        mesh.attributes[".corner_vert"].data.foreach_get("value", corners)
        mesh.polygons.foreach_get("loop_start", starts)
    return corners, starts


def triangulate(
    source: bpy.types.Mesh, original: bpy.types.Mesh | None, corners: NDArray[np.int32], starts: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Blender's own triangles of the object's mesh where its faces are those that entered; else quads are split and
    only larger faces left to Blender. Neither depends on the frame, unless larger faces come out of a modifier."""
    if original is not None and len(source.polygons) == len(original.polygons):
        own_corners, own_starts = face_arrays(original)
        if same(own_corners, corners) and same(own_starts, starts):
            return loop_triangles(original)
    small = split_small_faces(corners, starts)
    return loop_triangles(source) if small is None else small


def loop_triangles(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """Blender's triangles as (F, 3) vertex indices."""
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return triangles.reshape(-1, 3)


def own_shape(mesh: bpy.types.Mesh) -> tuple[Positions, NDArray[np.int32]]:
    """(V, 3) positions and (F, 3) triangles of an object's own mesh, before any modifier."""
    positions = attribute(mesh, "position", "vector", 3, np.float32)
    return np.empty((0, 3), np.float32) if positions is None else positions.reshape(-1, 3), loop_triangles(mesh)


def same(one: NDArray[Any], other: NDArray[Any] | None) -> bool:
    """Equal in every element."""
    return other is not None and np.array_equal(one, other)
