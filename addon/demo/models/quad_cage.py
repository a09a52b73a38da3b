# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed cage of quads, drawn out face by face (numpy only)."""

from typing import Any

import numpy as np

from .model import Array

Place = tuple[float, float, float]


class QuadCage:
    """``points`` and ``quads``, each quad's corners in turn about its outward side."""

    def __init__(self) -> None:
        self.points: list[Array] = []
        self.quads: list[tuple[int, ...]] = []

    def add(self, places: Any) -> list[int]:
        """Adds points; their numbers."""
        first = len(self.points)
        self.points += [np.asarray(place, dtype=np.float64) for place in places]
        return list(range(first, len(self.points)))

    def draw_out(self, quad: int, sections: list[tuple[Place, Place, float, float]]) -> None:
        """Draws the quad out, section after section: each the middle, the direction in which it looks, and half its
        width and height along the quad's first and second edge."""
        corners = np.array([self.points[corner] for corner in self.quads[quad]])
        across = corners[1] + corners[2] - corners[0] - corners[3]
        for middle, looks, width, height in sections:
            normal = np.array(looks) / np.linalg.norm(looks)
            across = _unit(across - (across @ normal) * normal)
            up = np.cross(normal, across)
            signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
            ring = self.add(np.array(middle) + a * width * across + b * height * up for a, b in signs)
            self._move_quad(quad, ring)

    def _move_quad(self, quad: int, ring: list[int]) -> None:
        before = self.quads[quad]
        for a in range(4):
            b = (a + 1) % 4
            self.quads.append((before[a], before[b], ring[b], ring[a]))
        self.quads[quad] = tuple(ring)


def _unit(vector: Array) -> Array:
    unit: Array = vector / np.linalg.norm(vector)
    return unit
