# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparing arrays that may be absent."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def same_array(one: NDArray[Any] | None, other: NDArray[Any] | None) -> bool:
    """Equal in every element, or both None."""
    if one is None or other is None:
        return one is other
    return one is other or np.array_equal(one, other)
