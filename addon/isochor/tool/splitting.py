# SPDX-License-Identifier: GPL-3.0-or-later
"""Splits a mesh where a Volume Lattice bends it, until its straight edges follow the deformed space.

Edges are split in their middle, wherever they are bent, and faces along with them: so nothing cracks, and what
Blender's own Subdivide keeps is kept (materials, UVs, colours, vertex groups, seams).
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray

import isochor

from ..core import problem, splitting
from ..core.request import Request
from ..core.words import Sentence, together
from . import evaluated
from .job import Memory

Indices = NDArray[np.int32]

LEVELS = 10
"""Halvings of an edge at most: a thousandth of its length."""
MOST_VERTICES = 2_000_000
INFLUENCE, REGION = "isochor influence", "isochor region"
"""Numbers of vertices that are carried along, and do not stay."""


@dataclass
class Splitted:
    """A mesh that is split, not yet anybody's: hand it over with ``give``, and free it. ``shape`` (V, 3) float32, where
    the modifier takes it; ``left``: how many edges are still bent too much."""

    mesh: bmesh.types.BMesh
    shape: NDArray[np.float32] = field(repr=False)
    left: int
    problems: tuple[str, ...]

    def give(self, obj: bpy.types.Object) -> None:
        """Makes it the object's own mesh, undeformed; its materials and names of groups stay."""
        for name in (INFLUENCE, REGION):
            layer = self.mesh.verts.layers.float.get(name)
            if layer is not None:
                self.mesh.verts.layers.float.remove(layer)
        self.mesh.to_mesh(obj.data)
        obj.data.update()


@dataclass(frozen=True)
class _Faces:
    """Number of corners, index of the first one, and vertex and edge of each corner."""

    sizes: Indices
    starts: Indices
    vertices: Indices
    edges: Indices


def split(obj: bpy.types.Object, memory: Memory, tolerance: float) -> Splitted:
    """The object's own mesh, split until no edge is bent by more than ``tolerance``, a length in the world. ``memory``
    is of the modifier, which its own vertices enter. The caller frees the mesh. Raises Problem."""
    first = memory.asked
    if first is None:
        raise problem.Problem(problem.not_shown(obj.name))
    longest = float(np.linalg.norm(evaluated.matrix(obj)[:3, :3], 2)) or 1.0
    mesh = bmesh.new()
    try:
        mesh.from_mesh(obj.data)
        _carry(mesh, first)
        with _scratch() as scratch:
            return _split(mesh, scratch, first, _own_volumes(memory), tolerance / longest)
    except BaseException:
        mesh.free()
        raise


def _split(
    mesh: bmesh.types.BMesh,
    scratch: bpy.types.Mesh,
    first: Request,
    own: NDArray[np.float64] | None,
    tolerance: float,
) -> Splitted:
    level = 0
    while True:
        mesh.to_mesh(scratch)
        request, outcome = splitting.solved(first, own, _read(scratch, first))
        shape, control = outcome.vertices, outcome.report.control
        if shape is None or control is None:
            raise problem.Problem(together(outcome.report.problems))
        faces = _faces(scratch)
        bent = _to_split(_pairs(scratch), faces, partial(splitting.bent, request, control, tolerance))
        left = int(bent.sum())
        if not left or level == LEVELS or len(scratch.vertices) + left > MOST_VERTICES:
            return Splitted(mesh, np.asarray(shape, np.float32), left, outcome.report.problems)
        _subdivide(mesh, bent, faces)
        level += 1


def _to_split(edges: Indices, faces: _Faces, bent: Callable[[Indices], NDArray[np.bool_]]) -> NDArray[np.bool_]:
    """(E,) bent edges, and all those of faces that are bent across."""
    found = bent(edges) if len(edges) else np.zeros(0, np.bool_)
    across, face = _diagonals(faces)
    if len(across):
        crooked = np.zeros(len(faces.sizes), np.bool_)
        crooked[face[bent(across)]] = True
        found[faces.edges[np.repeat(crooked, faces.sizes)]] = True
    return found


def _diagonals(faces: _Faces) -> tuple[Indices, Indices]:
    """(D, 2) pairs of vertices across faces of more than three corners, and the face of each: both of a quad, those
    from the first corner of larger ones."""
    pairs, of_face = [], []
    for size in np.unique(faces.sizes[faces.sizes > 3]):
        chosen = np.flatnonzero(faces.sizes == size)
        first = faces.starts[chosen]
        steps = [(0, step) for step in range(2, size - 1)] + ([(1, 3)] if size == 4 else [])
        for one, other in steps:
            pairs.append(np.stack([faces.vertices[first + one], faces.vertices[first + other]], axis=-1))
            of_face.append(chosen)
    if not pairs:
        return np.empty((0, 2), np.int32), np.empty(0, np.int32)
    return np.concatenate(pairs).astype(np.int32), np.concatenate(of_face).astype(np.int32)


def _subdivide(mesh: bmesh.types.BMesh, bent: NDArray[np.bool_], faces: _Faces) -> None:
    """Halves the bent edges. Faces of more than four corners that have one are cut into triangles first, since
    Subdivide would only make their rim finer."""
    at_corners = bent[faces.edges]
    starts, sizes = faces.starts, faces.sizes
    large = [face for face in np.flatnonzero(sizes > 4) if at_corners[starts[face] : starts[face] + sizes[face]].any()]
    mesh.edges.ensure_lookup_table()
    mesh.faces.ensure_lookup_table()
    chosen = [mesh.edges[index] for index in np.flatnonzero(bent)]
    if len(large):
        bmesh.ops.triangulate(mesh, faces=[mesh.faces[index] for index in large])
    bmesh.ops.subdivide_edges(mesh, edges=chosen, cuts=1, use_grid_fill=True, use_single_edge=True)


def _carry(mesh: bmesh.types.BMesh, first: Request) -> None:
    """Puts the numbers of the first request onto the vertices."""
    region = None if first.bodies is None else first.bodies.region
    for name, values in ((INFLUENCE, first.influence), (REGION, region)):
        if values is not None:
            layer = mesh.verts.layers.float.new(name)
            for vertex, value in zip(mesh.verts, values, strict=True):
                vertex[layer] = float(value)


def _read(scratch: bpy.types.Mesh, first: Request) -> splitting.Split:
    positions = evaluated.attribute(scratch, "position", "vector", 3, np.float32)
    triangles = evaluated.loop_triangles(scratch)
    return splitting.Split(
        np.empty((0, 3), np.float32) if positions is None else positions.reshape(-1, 3),
        evaluated.attribute(scratch, INFLUENCE, "value", 1, np.float32),
        evaluated.attribute(scratch, REGION, "value", 1, np.float32),
        triangles if first.triangles is not None else None,
    )


def _pairs(scratch: bpy.types.Mesh) -> Indices:
    """(E, 2) vertices of each edge."""
    found = np.empty(len(scratch.edges) * 2, np.int32)
    scratch.edges.foreach_get("vertices", found)
    return found.reshape(-1, 2)


def _faces(scratch: bpy.types.Mesh) -> _Faces:
    def read(holder: Any, name: str) -> Indices:
        found = np.empty(len(holder), np.int32)
        holder.foreach_get(name, found)
        return found

    polygons, loops = scratch.polygons, scratch.loops
    sizes, starts = read(polygons, "loop_total"), read(polygons, "loop_start")
    return _Faces(sizes, starts, read(loops, "vertex_index"), read(loops, "edge_index"))


def _own_volumes(memory: Memory) -> NDArray[np.float64] | None:
    """Of the bodies of the mesh that entered; None where it encloses nothing."""
    binding = memory.report.embedded
    try:
        return None if binding is None else np.asarray(binding.reference_volumes)
    except isochor.Error:
        return None


@contextmanager
def _scratch() -> Iterator[bpy.types.Mesh]:
    """A mesh to read arrays from, which does not stay in the file."""
    mesh = bpy.data.meshes.new(".Isochor Split")
    try:
        yield mesh
    finally:
        bpy.data.meshes.remove(mesh)


def left_over(name: str, left: int) -> str:
    """Warns that edges are still bent."""
    return Sentence(
        "{name}: {count} edges are still farther from the deformed space than Tolerance says, and would get too small"
        " or too many: raise it",
        name=name,
        count=left,
    )
