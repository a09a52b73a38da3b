# SPDX-License-Identifier: GPL-3.0-or-later
"""A fluted cup with a handle, as thrown clay: one handle in the topologist's sense too (numpy only)."""

import numpy as np
from relief import inside

from .distances import arc, chain, joined
from .implicit import surface
from .model import Array, Model

SPACING = 0.04564
"""Of the grid: gives as many points as the volume paper's cup has, 5,668."""
WALL = [(0.0, 0.07), (0.3, 0.07), (0.42, 0.16), (0.5, 0.4), (0.5, 0.62), (0.45, 0.86), (0.5, 1.08)]
"""(radius, height) of the middle of the wall, from the axis to the lip."""
WALL_RADII = [0.08, 0.08, 0.072, 0.066, 0.064, 0.062, 0.062]
FOOT = [(0.0, 0.03), (0.32, 0.03)]
HANDLE = [(0.5, 0.0, 0.86), (0.72, 0.0, 0.96), (0.92, 0.0, 0.8), (0.86, 0.0, 0.5), (0.66, 0.0, 0.32), (0.5, 0.0, 0.3)]
FLUTES = 14


def make_cup() -> Model:
    """Stands on z = 0 about the z axis, the handle towards +x. Values: glaze, lining."""
    points, triangles = surface(_distance, (-0.7, -0.7, -0.12), (1.1, 0.7, 1.25), SPACING)
    around = np.arctan2(points[:, 1], points[:, 0])
    out = np.hypot(points[:, 0], points[:, 1])
    drips = 0.36 + 0.05 * np.sin(5.0 * around) + 0.035 * np.sin(9.0 * around + 1.0)
    lining = np.maximum(out - _wall_at(points[:, 2]), 0.1 - points[:, 2])
    points[:, 2] -= points[:, 2].min()
    return Model(points, triangles, {"glaze": drips - points[:, 2], "lining": lining})


def _wall_at(height: Array) -> Array:
    """Radius of the middle of the wall."""
    curve = np.array(arc(WALL[2:], 40))
    return np.interp(height, curve[:, 1], curve[:, 0])


def _distance(points: Array) -> Array:
    out, height = np.hypot(points[..., 0], points[..., 1]), points[..., 2]
    section = np.stack([out, height], axis=-1)
    wall = [WALL[0], *arc(WALL[1:], 14)]
    radii = list(np.interp([z for _, z in wall], [z for _, z in WALL[1:]], WALL_RADII[1:]))
    body = joined(chain(section, wall, radii), chain(section, FOOT, [0.06, 0.06]), 0.05)
    waves = np.cos(FLUTES * np.arctan2(points[..., 1], points[..., 0]))
    outside = inside(_wall_at(height) - out, 0.04) * inside(0.2 - height, 0.12) * inside(height - 0.9, 0.12)
    flat = points * np.array([1.0, 0.72, 1.0])
    handle = chain(flat, arc(HANDLE, 16), list(np.interp(np.linspace(0, 1, 16), [0, 0.5, 1], [0.068, 0.074, 0.066])))
    return joined(body + 0.016 * waves * outside, handle, 0.1)
