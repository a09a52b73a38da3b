# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed, consistently oriented triangle meshes for the tests, and some deliberately broken ones.

Every function returns ``(vertices, triangles)``: float64 (V, 3) in object units and int32 (F, 3), wound so that the
signed volume is positive, unless its name says otherwise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float64], NDArray[np.int32]]


def icosphere(level: int, radius: float = 0.45, centre=(0.5, 0.5, 0.5)) -> Mesh:
    """Icosahedron split ``level`` times and pushed onto a sphere: 10·4^level + 2 vertices, 20·4^level triangles."""
    points, triangles = _icosahedron()
    for _ in range(level):
        points, triangles = _split(points, triangles)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * radius + np.asarray(centre, dtype=float), triangles


def bumpy_ball(level: int = 3, roughness: float = 0.25, seed: int = 7, centre=(0.5, 0.5, 0.5)) -> Mesh:
    """Sphere whose every vertex has its own random radius in [0.45 (1 − roughness), 0.45]: star-shaped, so V > 0."""
    points, triangles = icosphere(level, 1.0, (0.0, 0.0, 0.0))
    radii = 0.45 * (1.0 - roughness * np.random.default_rng(seed).random(len(points)))
    return points * radii[:, None] + np.asarray(centre, dtype=float), triangles


def torus(around: int = 32, across: int = 16, major: float = 0.3, minor: float = 0.14, centre=(0.5, 0.5, 0.5)) -> Mesh:
    """Torus about the z axis: genus 1."""
    turn, roll = np.meshgrid(
        np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij"
    )
    ring = major + minor * np.cos(roll)
    points = np.stack([ring * np.cos(turn), ring * np.sin(turn), minor * np.sin(roll)], axis=-1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    here, ahead = i * across + j, (i + 1) % around * across + j
    beside, both = i * across + (j + 1) % across, (i + 1) % around * across + (j + 1) % across
    triangles = np.concatenate([np.stack([here, ahead, both], 1), np.stack([here, both, beside], 1)])
    return points + np.asarray(centre, dtype=float), triangles.astype(np.int32)


def box(splits: int = 6, low=(0.1, 0.1, 0.1), high=(0.9, 0.9, 0.9)) -> Mesh:
    """Axis-aligned box, each side cut into splits² squares of two triangles."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    numbers: dict[tuple[int, ...], int] = {}
    triangles: list[tuple[int, int, int]] = []
    for axis in range(3):
        for side in (0, splits):
            for i in range(splits):
                for j in range(splits):
                    corners = [_box_corner(axis, side, i + di, j + dj) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    a, b, c, d = (numbers.setdefault(corner, len(numbers)) for corner in corners)
                    triangles += [(a, b, c), (a, c, d)] if side else [(a, c, b), (a, d, c)]
    grid = np.array(list(numbers), dtype=float) / splits
    return low + grid * (high - low), np.array(triangles, dtype=np.int32)


def tetrahedron(scale: float = 0.5, corner=(0.2, 0.2, 0.2)) -> Mesh:
    """Corner tetrahedron of volume scale³/6."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float) * scale + np.asarray(corner)
    return points, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)


def two_islands() -> Mesh:
    """A ball and a separate box in one mesh."""
    return joined(icosphere(2, 0.18, (0.25, 0.3, 0.3)), box(4, (0.55, 0.5, 0.45), (0.95, 0.9, 0.95)))


def tiny_beside_huge() -> Mesh:
    """A sphere of radius 0.4 and one a thousandth of that beside it, in one mesh."""
    return joined(icosphere(3, 0.4, (0.45, 0.5, 0.5)), icosphere(1, 4e-4, (0.95, 0.9, 0.9)))


def joined(first: Mesh, second: Mesh) -> Mesh:
    """Both meshes as one, unconnected."""
    return np.concatenate([first[0], second[0]]), np.concatenate([first[1], second[1] + len(first[0])]).astype(np.int32)


def inside_out(mesh: Mesh) -> Mesh:
    """The same surface with every triangle wound the other way: the volume changes its sign."""
    return mesh[0], np.ascontiguousarray(mesh[1][:, ::-1])


def opened(mesh: Mesh, triangle: int = 0) -> Mesh:
    """Without one triangle: a hole of three boundary edges."""
    return mesh[0], np.delete(mesh[1], triangle, axis=0)


def one_flipped(mesh: Mesh, triangle: int = 0) -> Mesh:
    """One triangle wound against its three neighbours."""
    triangles = mesh[1].copy()
    triangles[triangle] = triangles[triangle][::-1]
    return mesh[0], triangles


def with_fin(mesh: Mesh) -> Mesh:
    """One more triangle standing on an edge of the surface: three triangles share that edge."""
    a, b, _ = mesh[1][0]
    points = np.concatenate([mesh[0], [mesh[0][a] + [0.01, 0.02, 0.03]]])
    return points, np.concatenate([mesh[1], [[a, b, len(mesh[0])]]]).astype(np.int32)


def sharing_an_edge() -> Mesh:
    """Two closed tetrahedra with one edge in common: every edge is used equally both ways, one by four triangles."""
    points, first = tetrahedron()
    second = np.array([0, 3, 4, 5])[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]]
    points = np.concatenate([points, points[0] - [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]])
    return points, np.concatenate([first, second]).astype(np.int32)


def flat() -> Mesh:
    """A closed surface pressed into the plane z = 0.5: its volume is zero."""
    points, triangles = icosphere(2)
    points[:, 2] = 0.5
    return points, triangles


def _box_corner(axis: int, side: int, i: int, j: int) -> tuple[int, ...]:
    corner = [0, 0, 0]
    corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = side, i, j
    return tuple(corner)


def _icosahedron() -> Mesh:
    golden = (1 + 5**0.5) / 2
    points = np.array(
        [
            [-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0],
            [0, -1, golden], [0, 1, golden], [0, -1, -golden], [0, 1, -golden],
            [golden, 0, -1], [golden, 0, 1], [-golden, 0, -1], [-golden, 0, 1],
        ]
    )  # fmt: skip
    triangles = np.array(
        [
            [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
            [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5],
            [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
        ],
        dtype=np.int32,
    )  # fmt: skip
    return points / np.linalg.norm(points[0]), triangles


def _split(points: NDArray[np.float64], triangles: NDArray[np.int32]) -> Mesh:
    """Every triangle into four, at its edges' midpoints."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges, which = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    ab, bc, ca = (which.reshape(3, -1) + len(points)).astype(np.int32)
    a, b, c = triangles.T
    split = np.concatenate([np.stack(corners, 1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return np.concatenate([points, points[edges].mean(axis=1)]), split.astype(np.int32)
