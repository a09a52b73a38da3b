# SPDX-License-Identifier: GPL-3.0-or-later
"""How signed distances become relief (numpy only)."""

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]


def inside(distance: Values, softness: float) -> Values:
    """1 well inside, 0 outside, with a smooth edge `softness` wide that ends at distance 0."""
    share = np.clip(-distance / softness, 0, 1)
    return share * share * (3 - 2 * share)
