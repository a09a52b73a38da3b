# SPDX-License-Identifier: GPL-3.0-or-later
"""What a model is: points, triangles, and the values at its points that colour it (numpy only)."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triangles = NDArray[np.int32]


@dataclass(frozen=True)
class Model:
    """``points`` (V, 3), ``triangles`` (F, 3) wound outwards, ``values`` (V,) by name: signed distances to an edge of
    colour, negative inside."""

    points: Array
    triangles: Triangles
    values: dict[str, Array] = field(default_factory=dict)

    @property
    def is_closed(self) -> bool:
        """Whether every edge has exactly one triangle on each side."""
        edges = np.concatenate([self.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]).astype(np.int64)
        keys = edges[:, 0] * len(self.points) + edges[:, 1]
        back = edges[:, 1] * len(self.points) + edges[:, 0]
        return len(np.unique(keys)) == len(keys) and bool(np.isin(keys, back).all())

    @property
    def genus(self) -> int:
        """Number of handles, of a closed surface in one piece."""
        characteristic = len(self.points) - len(self.triangles) * 3 // 2 + len(self.triangles)
        return (2 - characteristic) // 2
