# SPDX-License-Identifier: GPL-3.0-or-later
"""What the vertex group that a Blender lattice itself names does to the vertices in it.

Blender blends the group's weights g like displacements and then takes that share of the way: with w the vertex's own
weight (strength times vertex group) and B the points' shares at the vertex, p' = p + w (sum B g) w (sum B d). The own
weight counts twice.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bound import Embedding
from .grid import Grid, build_lattice

Array = NDArray[np.float64]


def shares(grid: Grid, bound: Embedding | None, positions: NDArray[np.floating[Any]], group: Array) -> Array:
    """(V,) sum B g at vertices (V, 3) of the deformed object, for weights (nu, nv, nw) of a lattice's points. With
    interpolation types that overshoot it may leave [0, 1]."""
    lattice = build_lattice(grid if bound is None else bound.grid)
    rest = np.asarray(lattice.rest if bound is None else bound.control)
    points = np.asarray(positions, np.float64)
    if bound is not None and bound.is_shaped:
        parameters = lattice.invert(points, rest)[0]
    else:
        parameters = lattice.parameters(points)
    lifted = rest.copy()
    lifted[..., 0] += group
    return np.asarray(lattice.evaluate(parameters, lifted) - lattice.evaluate(parameters, rest))[:, 0]


def weakened(influence: NDArray[np.float32] | None, share: Array) -> NDArray[np.float32]:
    """(V,) how much of the deformation each vertex takes, in [0, 1], of what it took without the group."""
    own = 1.0 if influence is None else influence.astype(np.float64)
    return np.clip(own * own * share, 0.0, 1.0).astype(np.float32)
