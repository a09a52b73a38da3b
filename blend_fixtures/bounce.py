# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounce of the demonstration ball: how the lattice is shaped and when (numpy only).

Lengths are in ball radii, frames at 24 a second. Frame 49 equals frame 1, so frames 1 to 48 loop.
"""

import numpy as np
from numpy.typing import NDArray

FRAME_START, FRAME_END = 1, 48
FRAMES_PER_SECOND = 24

# Frame -> share of the volume that the plain lattice loses there (the volume paper's figure 1).
MARKED_LOSSES = {16: 0.28, 19: 0.51, 24: 0.64}
DEEPEST_LOSS = 0.64
STRETCH_GAIN = 0.12

# Spacing of the squashed lattice's layers grows by this share from the middle to the top and shrinks towards the
# ground: contact flattens the underside first. Below 1.25 the layers of a 6-point axis keep their order: no folds.
CONTACT_GRADE = 0.7

APEX = 0.9
FALL = ((1, APEX), (13, 0.0), (35, 0.0), (49, APEX))  # (frame, height of the underside); parabolas in the air
SQUASH = ((13, 0.0), (16, 0.28), (19, 0.51), (24, 0.64), (29, 0.51), (32, 0.28), (35, 0.0))  # (frame, loss)
STRETCH = ((1, 0.0), (12, 1.0), (15, 0.0), (33, 0.0), (36, 1.0), (49, 0.0))  # (frame, share of STRETCH_GAIN)


def graded_heights(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Heights (n,) of the lattice's layers for the squashed shape, before scaling; `heights` evenly spaced."""
    steps = np.diff(heights)
    middle = np.linspace(-1, 1, 2 * len(steps) + 1)[1::2]
    return np.concatenate(([0.0], np.cumsum(steps * (1 + CONTACT_GRADE * middle))))
