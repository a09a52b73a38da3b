# SPDX-License-Identifier: GPL-3.0-or-later
"""A screwdriver that stands on its blade: fluted handle, bolster, shaft and flat tip (numpy only)."""

import numpy as np
from rings import ring_triangles

from .model import Array, Model

SIDES, RINGS = 150, 181
"""150 * 181 + 2 = 27,152 points, as many as the volume paper's screwdriver has."""
# Height and half-widths along x and y, from the tip up.
PROFILE = np.array(
    [
        (0.0, 0.118, 0.016),
        (0.1, 0.13, 0.036),
        (0.28, 0.1, 0.062),
        (0.4, 0.066, 0.066),
        (0.95, 0.066, 0.066),
        (0.98, 0.1, 0.1),
        (1.1, 0.1, 0.1),
        (1.13, 0.15, 0.15),
        (1.19, 0.16, 0.16),
        (1.24, 0.15, 0.15),
        (1.3, 0.17, 0.17),
        (1.48, 0.27, 0.27),
        (1.7, 0.31, 0.31),
        (2.0, 0.3, 0.3),
        (2.16, 0.265, 0.265),
        (2.24, 0.225, 0.225),
        (2.3, 0.23, 0.23),
        (2.37, 0.2, 0.2),
        (2.405, 0.12, 0.12),
        (2.41, 0.04, 0.04),
    ]
)
HANDLE_FROM, BAND_FROM, BAND_TO = 1.25, 2.19, 2.27
FLUTES_FROM, FLUTES_TO, FLUTES = 1.36, 2.13, 8
BLADE_TO, HEX_FROM, HEX_TO = 0.36, 0.97, 1.115


def make_screwdriver() -> Model:
    """Stands on z = 0 on the z axis. Values: handle, band."""
    heights, wide, deep = _rings()
    angle = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    outline = _outline(heights[:, None], angle[None, :])
    rings = np.stack([outline * np.cos(angle) * wide[:, None], outline * np.sin(angle) * deep[:, None]], axis=-1)
    level = np.broadcast_to(heights[:, None, None], (*rings.shape[:2], 1))
    ends = np.array([[0.0, 0.0, heights[0]], [0.0, 0.0, heights[-1]]])
    points = np.concatenate([np.concatenate([rings, level], axis=-1).reshape(-1, 3), ends])
    band = np.maximum(BAND_FROM - points[:, 2], points[:, 2] - BAND_TO)
    return Model(points, ring_triangles(len(points), SIDES), {"handle": HANDLE_FROM - points[:, 2], "band": band})


def _rings() -> tuple[Array, Array, Array]:
    """Height and half-widths of each ring, evenly along the outline but for the flat tip, which five rings close."""
    tip = np.linspace(0.1, 1.0, 5, endpoint=False)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(PROFILE, axis=0) * [1.0, 1.0, 0.4], axis=1))])
    at = np.linspace(0.0, length[-1], RINGS - len(tip))
    heights, wide, deep = (np.interp(at, length, column) for column in PROFILE.T)
    rows = [(heights, np.zeros(len(tip))), (wide, tip * wide[0]), (deep, tip * deep[0])]
    height, width, depth = (np.concatenate([start, _smoothed(rest)]) for rest, start in rows)
    return height, width, depth


def _smoothed(values: Array) -> Array:
    """Rounds the profile's corners off; its ends stay."""
    for _ in range(2):
        values = np.concatenate([values[:1], 0.25 * values[:-2] + 0.5 * values[1:-1] + 0.25 * values[2:], values[-1:]])
    return values


def _between(height: Array, low: float, high: float, soft: float) -> Array:
    """1 between the heights, 0 beyond, over the width ``soft``."""
    share: Array = np.clip((height - low) / soft, 0.0, 1.0) * np.clip((high - height) / soft, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _outline(height: Array, angle: Array) -> Array:
    """Factor on the radius: square at the blade, six-sided at the bolster, fluted at the handle, round elsewhere."""
    cosine, sine = np.abs(np.cos(angle)), np.abs(np.sin(angle))
    square = (cosine**8 + sine**8) ** (-1.0 / 8.0)
    sixth = np.pi / 3.0
    hexagon = np.cos(sixth / 2.0) / np.cos((angle + sixth / 2.0) % sixth - sixth / 2.0)
    flutes = 1.0 - 0.17 * np.clip(np.cos(FLUTES * angle), 0.0, 1.0) ** 1.5
    found: Array = 1.0 + (square - 1.0) * _between(height, -1.0, BLADE_TO, 0.12)
    found = found + (1.05 * hexagon - 1.0) * _between(height, HEX_FROM, HEX_TO, 0.02)
    return found + (flutes - 1.0) * _between(height, FLUTES_FROM, FLUTES_TO, 0.14)
