# SPDX-License-Identifier: GPL-3.0-or-later
"""How much each control point resists the correction: weights for ``isochor.Binding.preserve``."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import isochor

Array = NDArray[np.float64]


def of_stiffness(stiffness: NDArray[np.floating[Any]]) -> Array:
    """Weights from stiffness in [0, 1]: a point moves 1 - stiffness times as far as a free one with the same pull on
    the volume, since the correction is divided by the weights; at 1 it is frozen."""
    free = 1.0 - np.clip(stiffness.astype(np.float64), 0.0, 1.0)
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / free)


def of_loss(lattice: isochor.Lattice, control: Array, rest: Array | None, share: float) -> Array:
    """Weights that lead the correction to where the lattice lost or gained volume: 1 everywhere at share 0, the native
    library's own at share 1."""
    lost = lattice.loss_weights(control, rest=rest)
    return np.asarray(1.0 - share + share * lost)


def product(factors: list[Array]) -> Array | None:
    """All multiplied; None where there are none."""
    return np.asarray(np.prod(factors, axis=0)) if factors else None
