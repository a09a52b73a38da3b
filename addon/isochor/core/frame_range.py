# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges of frames as a command line writes them; its texts are English."""

import re

from .problem import Problem

_RANGE = re.compile(r"(-?\d+)(?:(?:-|\.\.)(-?\d+))?")
_FARTHEST = 1_048_574
"""The last frame that Blender knows; the first is its negative."""


def parse(text: str, option: str) -> tuple[int, int]:
    """First and last frame of a text such as "1-250", "7" or "-5..10". Raises Problem, naming the option."""
    found = _RANGE.fullmatch(text.strip())
    if found is None:
        raise Problem(f"{option} “{text}” is no range of frames: write it like 1-250.")
    first = int(found[1])
    last = first if found[2] is None else int(found[2])
    if last < first:
        raise Problem(f"{option} “{text}” ends before it begins: write the first frame first.")
    if max(abs(first), abs(last)) > _FARTHEST:
        raise Problem(f"{option} “{text}” goes beyond the frames that Blender knows, {_FARTHEST} either way.")
    return first, last
