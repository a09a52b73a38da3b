# SPDX-License-Identifier: GPL-3.0-or-later
"""One bicubic Bezier patch for each quad of a closed cage, smooth across their edges (numpy only).

The first guess is Loop and Schaefer's (Approximating Catmull-Clark subdivision surfaces with bicubic patches, 2008),
which is C2 away from the cage's irregular points. The control points nearest to it are then sought that meet the
condition for a common tangent plane along every edge, left + right = (linear in t) times along, in the least squares'
sense where bicubic patches cannot meet it.
"""

from collections.abc import Iterator

import numpy as np

from .model import Array
from .patch_model import Indices, PatchModel
from .quad_cage import QuadCage

PRESS = 100.0
"""Weight of the tangents' conditions against staying at the first guess."""


def smooth_patches(cage: QuadCage) -> PatchModel:
    """A patch per quad."""
    points, quads = np.array(cage.points), np.array(cage.quads)
    patches = _numbered(quads, len(points))
    valence = np.bincount(quads.ravel(), minlength=len(points))
    guess = _first_guess(points, quads, valence, patches)
    return PatchModel(_with_tangent_planes(guess, patches, valence), patches)


def _numbered(quads: Indices, corners: int) -> Indices:
    """Indices (P, 4, 4) of control points: first the corners, then two an edge, then four a patch."""
    edges: dict[tuple[int, int], int] = {}
    for quad in quads:
        for a, b in zip(quad, np.roll(quad, -1)):
            edges.setdefault((min(a, b), max(a, b)), corners + 2 * len(edges))
    inner = corners + 2 * len(edges)
    patches = np.empty((len(quads), 4, 4), dtype=np.int32)
    for number, quad in enumerate(quads):
        rim = []
        for a, b in zip(quad, np.roll(quad, -1)):
            first = edges[min(a, b), max(a, b)]
            rim += [a, *((first, first + 1) if a < b else (first + 1, first))]
        patch = patches[number]
        patch[0, :3], patch[:3, 3] = rim[0:3], rim[3:6]
        patch[3, :0:-1], patch[:0:-1, 0] = rim[6:9], rim[9:12]
        patch[1:3, 1:3] = inner + 4 * number + np.array([[0, 1], [3, 2]])
    return patches


def _first_guess(points: Array, quads: Indices, valence: Array, patches: Indices) -> Array:
    """Loop and Schaefer's control points: inner ones from the quad, the others means of those around."""
    found = np.zeros((int(patches.max()) + 1, 3))
    shares = np.zeros(len(found))
    for quad, patch in zip(quads, patches):
        for turn, corner in enumerate(quad):
            near, far, opposite = points[quad[turn - 3]], points[quad[turn - 1]], points[quad[turn - 2]]
            inner = (valence[corner] * points[corner] + 2.0 * (near + far) + opposite) / (valence[corner] + 5.0)
            turned = np.rot90(patch, turn)
            found[turned[1, 1]] = inner
            shares[turned[1, 1]] = 1.0
            for place, weight in ((turned[0, 0], 1.0), (turned[0, 1], 1.0), (turned[1, 0], 1.0)):
                found[place] += weight * inner
                shares[place] += weight
    guess: Array = found / shares[:, None]
    return guess


def _with_tangent_planes(guess: Array, patches: Indices, valence: Array) -> Array:
    """The control points nearest to the guess that meet the conditions as well as may be."""
    rows = [row for rows in _conditions(patches, valence) for row in rows]
    matrix = np.zeros((len(rows), len(guess)))
    for number, row in enumerate(rows):
        for point, weight in row:
            matrix[number, point] += weight
    normal = np.eye(len(guess)) + PRESS**2 * matrix.T @ matrix
    found: Array = np.linalg.solve(normal, guess)
    return found


def _conditions(patches: Indices, valence: Array) -> Iterator[list[list[tuple[int, float]]]]:
    """Four conditions for each edge: sums of control points that must be 0. With e the edge's control points, l and r
    those beside it, in Bernstein coefficients: (l - e) + (r - e) = m(t) e'(t) / 3, m linear from 2 cos(2 pi / n) of the
    one end's valence n to minus that of the other."""
    sides = {}
    for patch in patches:
        for edge in range(4):
            turned = np.rot90(patch, edge)
            sides[tuple(turned[0].tolist())] = turned[1]
    for row, left in sides.items():
        if row[0] < row[3]:
            right = sides[row[::-1]][::-1]
            start, end = (2.0 * np.cos(2.0 * np.pi / valence[row[side]]) for side in (0, 3))
            yield [_condition(k, row, left, right, start, -end) for k in range(4)]


def _condition(
    k: int, row: tuple[int, ...], left: Indices, right: Indices, start: float, end: float
) -> list[tuple[int, float]]:
    terms = [(int(left[k]), 1.0), (int(right[k]), 1.0), (row[k], -2.0)]
    for weight, step in ((start * (3 - k) / 3.0, k), (end * k / 3.0, k - 1)):
        if weight:
            terms += [(row[step + 1], -weight), (row[step], weight)]
    return terms
