# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the viewport that were computed before, one memory for all modifiers of the session.

Renders go through each frame once: keeping theirs would cost memory and save nothing.
"""

from ..core.frames import Frames
from ..core.solver import Solver
from . import device

_frames = Frames()


def solver(mode: str) -> Solver:
    """A solver that remembers frames in the depsgraph mode VIEWPORT, and none in RENDER."""
    if mode != "VIEWPORT":
        return Solver()
    _frames.resize(device.memory_limit())
    return Solver(_frames)


def clear() -> None:
    """Lets go of all frames."""
    _frames.clear()


def forget(solver: Solver) -> None:
    """Lets go of the frames of one solver."""
    _frames.forget(solver)


def resize() -> None:
    """Keeps to the limit that the preferences now set."""
    _frames.resize(device.memory_limit())


def used() -> tuple[int, int]:
    """Number of frames kept, and the bytes they take."""
    return len(_frames), _frames.used
