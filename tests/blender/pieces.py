# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of the parts of a mesh, in float64 and by hand: connected pieces, and parts with holes closed by fans."""

from collections.abc import Iterator

import bpy
import numpy as np
import scenes
from numpy.typing import NDArray

Points = NDArray[np.float64]
Triangles = NDArray[np.int32]


def triangles_of(mesh: bpy.types.Mesh) -> Triangles:
    """(F, 3) as Blender cuts the faces of an undeformed mesh; the volume kept is that of these triangles."""
    mesh.calc_loop_triangles()
    found = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", found)
    return found.reshape(-1, 3)


def islands(triangles: Triangles, count: int) -> list[Triangles]:
    """The triangles of each piece that hangs together by its vertices, in order of its first vertex."""
    home = np.arange(count)
    changed = True
    while changed:
        least = home[triangles].min(axis=1)
        before = home.copy()
        np.minimum.at(home, triangles.reshape(-1), np.repeat(least, 3))
        changed = bool((home != before).any())
    return [triangles[home[triangles[:, 0]] == piece] for piece in np.unique(home[triangles[:, 0]])]


def loops(triangles: Triangles) -> Iterator[list[int]]:
    """The vertices round each hole, in the direction of the triangles along it."""
    sides = {(int(a), int(b)) for triangle in triangles for a, b in zip(triangle, np.roll(triangle, -1), strict=True)}
    onward = {a: b for a, b in sides if (b, a) not in sides}
    while onward:
        start, here = onward.popitem()
        loop = [start]
        while here != start:
            loop.append(here)
            here = onward.pop(here)
        yield loop


def volume(points: Points, triangles: Triangles) -> float:
    """Signed, with every hole closed by a fan about the mean of the vertices round it."""
    middle = points.mean(axis=0)
    a, b, c = (points - middle)[triangles].transpose(1, 0, 2)
    found = float(np.einsum("ij,ij->", a, np.cross(b, c)))
    for loop in loops(triangles):
        rim = points[loop] - middle
        found += float(np.einsum("ij,j->", np.cross(np.roll(rim, -1, axis=0), rim), rim.mean(axis=0)))
    return found / 6.0


def island_volumes(obj: bpy.types.Object) -> NDArray[np.float64]:
    """Of each piece of what Blender evaluates."""
    points = scenes.evaluated_positions(obj)
    return np.array([volume(points, piece) for piece in islands(triangles_of(obj.data), len(points))])


def region_volumes(obj: bpy.types.Object, inside: NDArray[np.bool_]) -> tuple[float, float]:
    """Of the triangles whose vertices are all ``inside`` (V,), and of the others, in what Blender evaluates."""
    points, triangles = scenes.evaluated_positions(obj), triangles_of(obj.data)
    there = inside[triangles].all(axis=1)
    return volume(points, triangles[there]), volume(points, triangles[~there])


def several(parts: list[tuple[Points, Triangles]], name: str = "Pieces") -> bpy.types.Object:
    """One mesh object of several meshes that do not touch."""
    offsets = np.cumsum([0, *(len(points) for points, _triangles in parts)])
    faces = [triangles + offset for (_points, triangles), offset in zip(parts, offsets[:-1], strict=True)]
    return scenes.mesh_object(name, np.concatenate([points for points, _ in parts]), np.concatenate(faces))


def tube(around: int = 32, rows: int = 12, radius: float = 0.6, height: float = 2.0) -> tuple[Points, Triangles]:
    """A cylinder along z without its two ends, wound outwards."""
    turn = 2.0 * np.pi * np.arange(around) / around
    levels = np.linspace(-height / 2.0, height / 2.0, rows)
    points = np.array([(radius * np.cos(t), radius * np.sin(t), z) for z in levels for t in turn])
    here = np.arange((rows - 1) * around)
    beside = here - here % around + (here + 1) % around
    lower = np.stack([here, beside, beside + around], axis=1)
    upper = np.stack([here, beside + around, here + around], axis=1)
    return points, np.concatenate([lower, upper]).astype(np.int32)


def cylinder(around: int = 32, rows: int = 24, radius: float = 0.4, height: float = 2.0) -> tuple[Points, Triangles]:
    """The same with its ends."""
    points, triangles = tube(around, rows, radius, height)
    last = len(points)
    ends = np.array([(0.0, 0.0, -height / 2.0), (0.0, 0.0, height / 2.0)])
    first, top = np.arange(around), np.arange(last - around, last)
    bottom_fan = np.stack([np.roll(first, -1), first, np.full(around, last)], axis=1)
    top_fan = np.stack([top, np.roll(top, -1), np.full(around, last + 1)], axis=1)
    return np.concatenate([points, ends]), np.concatenate([triangles, bottom_fan, top_fan]).astype(np.int32)
