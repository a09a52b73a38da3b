# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of lattices, shares and changes of volume for which the volume is promised, on every device."""

import numpy as np
from oracle import Spec

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-6": Spec((6, 6, 6), "bspline", 3, "clamped"),
    "uniform-10": Spec((10, 10, 10), "bspline", 3, "uniform"),
    "clamped-10": Spec((10, 10, 10), "bspline", 3, "clamped"),
    "mixed-degrees": Spec((5, 7, 8), "bspline", (1, 2, 5), "uniform"),
    "mixed-bernstein": Spec((3, 9, 5)),
}
SHARES = [(1, 1, 1), (1, 1, 0), (0, 0, 1), (1, 2, 0)]
# the plain lattice's volume over that at rest: losses of 28, 51, 64 and 85 %, of a twist, a dent, gains to +300 %
PLANNED = [
    ("squash", 0.72), ("squash", 0.49), ("squash", 0.36), ("squash", 0.15),
    ("twist", 0.34), ("dent", 0.6), ("wobble", 0.3), ("inflate", 4.0), ("spread", 4.0),
]  # fmt: skip
DTYPES = {"float64": np.float64, "float32": np.float32}
