# SPDX-License-Identifier: GPL-3.0-or-later
"""A word cut out of a plate with round strokes: flat letters of even thickness, each closed (numpy only)."""

from functools import cache

import numpy as np
from lettering import distance_to_segments, word_segments

from .implicit import surface
from .model import Array, Model

WORD, HEIGHT, STROKE = "ISOCHOR", 1.0, 0.12
THICKNESS = 0.16
SPACING = 0.04
EDGE = 0.03
"""Radius of the letters' edges."""


@cache
def make_sign() -> Model:
    """In the plane z = 0 and above it, centred in x and y."""
    segments = word_segments(WORD, HEIGHT)
    reach = np.abs(segments).reshape(-1, 2).max(axis=0) + STROKE + 3 * SPACING

    def distance(points: Array) -> Array:
        flat = distance_to_segments(points[..., :2].reshape(-1, 2), segments).reshape(points.shape[:-1]) - STROKE
        tall = np.abs(points[..., 2]) - THICKNESS / 2
        outside = np.hypot(np.maximum(flat + EDGE, 0.0), np.maximum(tall + EDGE, 0.0))
        rounded: Array = outside + np.minimum(np.maximum(flat, tall) + EDGE, 0.0) - EDGE
        return rounded

    low, high = (-reach[0], -reach[1], -0.2), (reach[0], reach[1], 0.2)
    points, triangles = surface(distance, low, high, SPACING)
    points[:, 2] -= points[:, 2].min()
    return Model(points, triangles, {"across": np.sin(np.pi * 4.0 * points[:, 0])})
