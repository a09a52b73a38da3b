# SPDX-License-Identifier: GPL-3.0-or-later
"""The cube of the volume paper's twist, with a chequer that shows how its sides turn (numpy only)."""

import numpy as np

from .cube_grid import cube_grid
from .model import Model

CELLS = 32
"""Along each edge: 6 * 32² + 2 = 6,146 points, the paper's number."""
FIELDS = 4
"""Of the chequer, along each edge."""


def make_twist_cube() -> Model:
    """Edges of length 2, standing on z = 0. Values: field, whose sign tells one field from the next; top."""
    points, triangles = cube_grid(CELLS)
    waves = np.sin(np.pi * FIELDS * (points + 1.0) / 2.0)
    face = np.abs(points).argmax(axis=1)
    across = np.array([[1, 2], [0, 2], [0, 1]])[face]
    field = np.take_along_axis(waves, across, axis=1).prod(axis=1)
    return Model(points + [0.0, 0.0, 1.0], triangles, {"field": field})
