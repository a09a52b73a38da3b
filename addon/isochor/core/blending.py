# SPDX-License-Identifier: GPL-3.0-or-later
"""How a lattice's control points blend: basis, Blender's interpolation types, weights."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import problem

Array = NDArray[np.float64]
Types = tuple[str, str, str]

NATIVE_INTERPOLATION: dict[str, Literal["linear", "cardinal", "catmull-rom", "bspline"]] = {
    "KEY_LINEAR": "linear",
    "KEY_CARDINAL": "cardinal",
    "KEY_CATMULL_ROM": "catmull-rom",
    "KEY_BSPLINE": "bspline",
}
"""Blender's interpolation types as the native library names them."""
LIGHTEST, MOST = 1e-3, 1e6
"""Least weight of a control point, since with none at all nothing would be left where it alone acts; and the largest,
which the native library takes."""
OVERSHOOTING = ("KEY_CARDINAL", "KEY_CATMULL_ROM")
"""Types with negative shares, which weights cannot divide by."""


@dataclass(frozen=True)
class Blending:
    """``basis``: one of settings.BASES; ``interpolation``: Blender's types along u, v, w, of its own basis alone;
    ``weights``: (nu, nv, nw) how strongly each control point pulls, or None where all do alike."""

    basis: str
    interpolation: Types | None = None
    weights: Array | None = field(default=None, repr=False)


def pulls(group: NDArray[np.floating[Any]], heaviest: float) -> Array | None:
    """Weights of control points: 1 where their weight in the group is 0, ``heaviest`` where it is 1, evenly between;
    None where all are alike, which is the same as none. Raises Problem where ``heaviest`` is no number."""
    if not isfinite(heaviest):
        raise problem.Problem(problem.not_finite(["Heaviest"]))
    found: Array = 1.0 + group.astype(np.float64) * (min(max(heaviest, LIGHTEST), MOST) - 1.0)
    return None if np.all(found == found.flat[0]) else found
