# SPDX-License-Identifier: GPL-3.0-or-later
"""A carved casket in red lacquer, whose fine relief shows what a deformation does to details (numpy only)."""

import numpy as np
from relief import inside

from .cube_grid import cube_grid
from .model import Array, Model

CELLS = 112
"""Along each edge: 6 * 112² + 2 = 75,266 points."""
HALF = np.array([1.0, 0.74, 0.68])
ROUNDING = 0.085
SOFT = 0.022
"""Width of the edges of the relief, a little more than a cell."""
ROPE_FROM, ROPE_TO, PANEL_FROM = 0.075, 0.165, 0.2
"""Distances from a face's border: a rope runs round a sunken panel."""
ROPE_TURNS = 26.0
"""Strands of the rope in two lengths."""
PETALS = 8


def make_casket() -> Model:
    """Stands on z = 0, centred. Values: gold, sunken."""
    grid, triangles = cube_grid(CELLS)
    inner = np.clip(grid * HALF, ROUNDING - HALF, HALF - ROUNDING)
    normal = grid * HALF - inner
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height, gold, sunken = (np.empty(len(grid)) for _ in range(3))
    face = np.abs(grid).argmax(axis=1)
    for axis in range(3):
        here = face == axis
        across = [other for other in range(3) if other != axis]
        place, half = (inner + ROUNDING * normal)[here][:, across], HALF[across]
        height[here], gold[here], sunken[here] = _face(place, half)
    points = inner + (ROUNDING + height[:, None]) * normal
    points[:, 2] -= points[:, 2].min()
    return Model(points, triangles, {"gold": gold, "sunken": sunken})


def _face(place: Array, half: Array) -> tuple[Array, Array, Array]:
    """Height, and the distances to what is gold and what is sunken, over one face of half the size ``half``."""
    border = half - np.abs(place)
    depth = border.min(axis=1)
    along = np.where(border[:, 0] < border[:, 1], place[:, 1], place[:, 0])
    middle = (ROPE_FROM + ROPE_TO) / 2.0
    rope = np.abs(depth - middle) - (ROPE_TO - ROPE_FROM) / 2.0
    twist = np.cos(np.pi * ROPE_TURNS * (along + 0.6 * (depth - middle)))
    sunken = PANEL_FROM - depth
    stud = np.hypot(*(border - middle).T) - 0.075
    ornament = [(rope, 0.038 * inside(rope, 0.045) * (0.8 + 0.2 * twist)), (stud, 0.07 * inside(stud, 0.075))]
    ornament += _rosette(place, 0.8 * (half.min() - PANEL_FROM))
    ornament += _fans(half - PANEL_FROM - np.abs(place), 0.42 * (half.min() - PANEL_FROM))
    gold = np.min([distance for distance, _ in ornament], axis=0)
    height = np.max([rise for _, rise in ornament], axis=0) - 0.045 * inside(sunken, SOFT)
    return height, gold, sunken


def _rosette(place: Array, radius: float) -> list[tuple[Array, Array]]:
    """Distances and heights of petals with a vein, leaves between them, and a boss in the middle."""
    out, turn = np.hypot(*place.T), np.arctan2(place[:, 1], place[:, 0])
    petal = np.abs(np.cos(PETALS / 2.0 * turn))
    leaf = np.abs(np.sin(PETALS / 2.0 * turn))
    petals = out - radius * (0.42 + 0.58 * petal**0.7)
    leaves = out - radius * (0.5 + 0.45 * leaf**5.0)
    vein = inside(0.05 - np.abs(np.sin(PETALS / 2.0 * turn)) * out / radius, 0.05)
    boss = out - 0.24 * radius
    ring = np.abs(out - 0.3 * radius) - 0.03 * radius
    return [
        (leaves, 0.035 * inside(leaves, 2.0 * SOFT)),
        (petals, 0.07 * inside(petals, 0.4 * radius) * (0.55 + 0.45 * vein)),
        (ring, 0.075 * inside(ring, SOFT)),
        (boss, 0.1 * inside(boss, 0.24 * radius)),
    ]


def _fans(corner: Array, radius: float) -> list[tuple[Array, Array]]:
    """Distance and height of a ribbed shell in each corner of the panel; ``corner``: distances from the corner."""
    out, turn = np.hypot(*corner.T), np.arctan2(corner[:, 1], corner[:, 0])
    shell = out - radius * (0.93 + 0.07 * np.abs(np.cos(10.0 * turn)))
    return [(shell, 0.05 * inside(shell, 1.5 * SOFT) * (0.6 + 0.4 * np.abs(np.cos(10.0 * turn))))]
