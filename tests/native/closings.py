# SPDX-License-Identifier: GPL-3.0-or-later
"""Which triangles make a body, and the fans that close its holes: by sets and walks, one triangle after another."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from oracle import Array

Faces = NDArray[np.integer]


def islands(triangles: Faces) -> list[Faces]:
    """The triangles joined by shared vertices, pieces in the order of their first triangle."""
    parent = list(range(int(np.max(triangles)) + 1))

    def root(v: int) -> int:
        while parent[v] != v:
            v = parent[v]
        return v

    for a, b, c in np.asarray(triangles).tolist():
        parent[root(b)] = root(a)
        parent[root(c)] = root(a)
    pieces: dict[int, list[list[int]]] = {}
    for triangle in np.asarray(triangles).tolist():
        pieces.setdefault(root(triangle[0]), []).append(triangle)
    return [np.array(piece) for piece in pieces.values()]


def regions(triangles: Faces, labels: Iterable[int]) -> list[Faces]:
    """The triangles of label 0, 1, …; those of label −1 belong to none."""
    labels = np.asarray(list(labels))
    return [np.asarray(triangles)[labels == label] for label in range(labels.max() + 1)]


def loops(triangles: Faces) -> list[list[int]]:
    """Boundary loops, each the vertices in the order of the triangles' own half-edges."""
    half_edges = {(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)}
    after = {a: b for a, b in half_edges if (b, a) not in half_edges}
    found = []
    while after:
        loop = [next(iter(after))]
        while (ahead := after.pop(loop[-1])) != loop[0]:
            loop.append(ahead)
        found.append(loop)
    return found


def closed(triangles: Faces, apexes: list[list[int]], count: int) -> Faces:
    """The triangles and a fan over each loop. `apexes` collects the loops: that of number k has vertex count + k."""
    fans = [np.asarray(triangles)]
    for loop in loops(triangles):
        apex = count + len(apexes)
        apexes.append(loop)
        fans.append(np.array([(b, a, apex) for a, b in zip(loop, loop[1:] + loop[:1])]))
    return np.concatenate(fans)


def with_apexes(values: Array, apexes: list[list[int]]) -> Array:
    """(V, …) values per vertex, followed by the mean over each loop."""
    return np.concatenate([values, *(values[loop].mean(axis=0, keepdims=True) for loop in apexes)])


def closed_volumes(vertices: Array, bodies: list[Faces]) -> Array:
    """Volume of each body of a mesh, its holes closed by fans, about its own mean vertex."""
    apexes: list[list[int]] = []
    closings = [closed(body, apexes, len(vertices)) for body in bodies]
    points = with_apexes(np.asarray(vertices, dtype=float), apexes)
    return np.array([_volume(points, closing) for closing in closings])


def _volume(points: Array, triangles: Faces) -> float:
    a, b, c = np.moveaxis(points[triangles] - points[triangles].mean(axis=(0, 1)), 1, 0)
    return float(np.sum(np.einsum("fi,fi->f", a, np.cross(b, c)).astype(np.longdouble)) / 6)
