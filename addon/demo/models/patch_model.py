# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed surface of bicubic Bezier patches that share control points, and its tessellation (numpy only)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .model import Array, Triangles

Indices = NDArray[np.int32]
EDGE_ROWS = ((0, 0), (0, 3)), ((0, 3), (3, 3)), ((3, 3), (3, 0)), ((3, 0), (0, 0))
"""Corners of a patch's control points at the ends of its four edges, in turn."""


class Tessellated(NamedTuple):
    """``vertices`` (T, 3), ``triangles`` (F, 3) wound outwards, ``patch`` (T,): one to which each vertex belongs."""

    vertices: Array
    triangles: Triangles
    patch: Indices


@dataclass(frozen=True)
class PatchModel:
    """``points`` (K, 3), ``patches`` (P, 4, 4) indices of the control points, v along the rows; u x v is outwards."""

    points: Array
    patches: Indices

    def evaluate(self, u: Array, v: Array) -> Array:
        """Points (P, n, 3) of every patch at the parameters (n,)."""
        weights = np.einsum("ni,nj->nij", bernstein(v), bernstein(u))
        return np.einsum("nij,pijc->pnc", weights, self.points[self.patches])

    def normals(self, u: Array, v: Array) -> Array:
        """Unit normals (P, n, 3) there."""
        control = self.points[self.patches]
        along_u = np.einsum("ni,nj,pijc->pnc", bernstein(v), bernstein(u, 2), np.diff(control, axis=2))
        along_v = np.einsum("ni,nj,pijc->pnc", bernstein(v, 2), bernstein(u), np.diff(control, axis=1))
        normal = np.cross(along_u, along_v)
        unit: Array = normal / np.linalg.norm(normal, axis=2, keepdims=True)
        return unit

    def tessellate(self, level: int) -> Tessellated:
        """Every patch in level x level quads, two triangles each; vertices on common edges are one."""
        steps = np.linspace(0.0, 1.0, level + 1)
        v, u = (place.ravel() for place in np.meshgrid(steps, steps, indexing="ij"))
        names = self._shared_names(level)
        count = int(names.max()) + 1
        vertices, patch = np.empty((count, 3)), np.empty(count, dtype=np.int32)
        vertices[names] = self.evaluate(u, v)
        patch[names] = np.arange(len(self.patches))[:, None]
        here = names.reshape(-1, level + 1, level + 1)
        a, b, c, d = here[:, :-1, :-1], here[:, :-1, 1:], here[:, 1:, 1:], here[:, 1:, :-1]
        triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
        return Tessellated(vertices, np.ascontiguousarray(triangles, dtype=np.int32), patch)

    def _shared_names(self, level: int) -> NDArray[np.int64]:
        """Number of the vertex (P, (level + 1)^2) at each sample: those on edges are named by the edge's own control
        points, so that two patches agree."""
        across = level + 1
        names = np.arange(len(self.patches) * across * across).reshape(-1, across, across)
        known: dict[tuple[int, ...], NDArray[np.int64]] = {}
        for name, patch in zip(names, self.patches):
            for edge in range(4):
                row, samples = np.rot90(patch, edge)[0], np.rot90(name, edge)[0]
                key, ordered = tuple(row.tolist()), samples
                if key[::-1] in known:
                    ordered[...] = known[key[::-1]][::-1]
                else:
                    known[key] = ordered.copy()
        return self._corners_shared(names)

    def _corners_shared(self, names: NDArray[np.int64]) -> NDArray[np.int64]:
        corners = {}
        replaced = np.arange(names.size)
        for name, patch in zip(names, self.patches):
            for row, column in ((0, 0), (0, -1), (-1, -1), (-1, 0)):
                vertex = corners.setdefault(int(patch[row, column]), int(name[row, column]))
                replaced[name[row, column]] = vertex
        unique = np.unique(replaced[names], return_inverse=True)[1]
        return unique.reshape(len(names), -1)


def bernstein(parameter: Array, degree: int = 3) -> Array:
    """(n, degree + 1) Bernstein polynomials of degree 2 or 3."""
    choose = {2: (1.0, 2.0, 1.0), 3: (1.0, 3.0, 3.0, 1.0)}[degree]
    power = np.arange(degree + 1)
    return np.array(choose) * parameter[:, None] ** power * (1.0 - parameter[:, None]) ** (degree - power)
