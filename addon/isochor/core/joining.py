# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the parts of one object's bake and puts them together into what a bake in one go would have written.

The command line alone does so: its texts are English."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import part_file
from .part_file import Damaged, Head, Whole
from .problem import Problem


@dataclass
class Found:
    """The parts in a folder that belong to one bake and are sound, and those that are not."""

    parts: list[tuple[Path, Head]] = field(default_factory=list)
    damaged: list[str] = field(default_factory=list)
    outdated: list[str] = field(default_factory=list)

    def covered(self) -> set[int]:
        """Indices of the samples that are there."""
        return {index for _path, head in self.parts for index in head.indices}

    def vertices(self) -> int:
        """Of every part; raises Problem where they differ."""
        counts = {head.vertices for _path, head in self.parts}
        if len(counts) != 1:
            name, words = self.parts[0][1].whole.object, ", ".join(map(str, sorted(counts)))
            raise Problem(
                f"The parts of “{name}” have different numbers of vertices ({words}): bake them again in one version."
            )
        return counts.pop()


def find(folder: Path, whole: Whole, wanted: range) -> Found:
    """Looks at every part in the folder, whatever it is called, and checks those of this bake that hold one of the
    wanted samples to the last byte."""
    found = Found()
    for path in _parts(folder):
        try:
            head = part_file.read_head(path)
            if _same_frames(head.whole, whole) and _overlap(head.indices, wanted):
                if head.whole.blend != whole.blend:
                    found.outdated.append(path.name)
                else:
                    found.parts.append((path, part_file.check(path)))
        except Damaged:
            found.damaged.append(path.name)
    return found


def asked_for(folder: Path, like: Whole) -> list[str]:
    """Names of the objects that the parts of such a bake, of whichever object, were asked for; none where that is all
    that there are, or there are no parts."""
    asked: list[tuple[str, ...]] = []
    for path in _parts(folder):
        with suppress(Damaged):
            head = part_file.read_head(path)
            if replace(head.whole, object=like.object) == like:
                asked.append(head.asked)
    return list(dict.fromkeys(name for names in asked for name in names)) if all(asked) else []


def missing_frames(found: Found, whole: Whole) -> list[int]:
    """Frames of which a sample is not there."""
    return sorted({whole.frame(index) for index in set(range(whole.count)) - found.covered()})


def require_complete(found: Found, whole: Whole) -> None:
    """Raises Problem, naming the missing frames and what may explain them."""
    missing = missing_frames(found, whole)
    if not missing:
        return
    text = f"“{whole.object}” lacks {frame_words(missing)} of {whole.first}-{whole.last}: bake those and join again."
    if found.damaged:
        text += f" Damaged: {', '.join(found.damaged)}."
    if found.outdated:
        text += f" Baked from another version of the .blend: {', '.join(found.outdated)}."
    raise Problem(text)


def joined(found: Found, whole: Whole) -> Iterator[NDArray[np.float32]]:
    """(V, 3) positions of every sample in order. Everything must be there."""
    index = 0
    while index < whole.count:
        holding = [(head.indices.stop, path) for path, head in found.parts if index in head.indices]
        stop, path = max(holding)
        yield from part_file.samples(path, range(index, stop))
        index = stop


def frame_words(frames: list[int]) -> str:
    """Sorted frames as people write them, such as “frames 3, 7-9”."""
    runs: list[list[int]] = []
    for frame in frames:
        if runs and frame == runs[-1][-1] + 1:
            runs[-1].append(frame)
        else:
            runs.append([frame])
    texts = [str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs]
    return f"frame{'s' if len(frames) > 1 else ''} {', '.join(texts)}"


def _parts(folder: Path) -> list[Path]:
    """Every file there that is named like a part; none where there is no folder."""
    return sorted(path for path in folder.glob(f"*{part_file.SUFFIX}") if path.is_file())


def _overlap(one: range, other: range) -> bool:
    return one.start < other.stop and other.start < one.stop


def _same_frames(one: Whole, other: Whole) -> bool:
    return (one.object, one.first, one.last, one.samples) == (other.object, other.first, other.last, other.samples)
