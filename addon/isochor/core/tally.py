# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the problems of a walk over frames, to tell each once instead of once a frame."""

from dataclasses import dataclass, field

from .words import Sentence, sentence, together


@dataclass
class Tally:
    """Which problem each object had, and in which frames, in the order found."""

    found: dict[tuple[str, str], list[str]] = field(default_factory=dict)

    def add(self, name: str, frame: str, problems: tuple[str, ...]) -> None:
        """Notes the problems of an object in a frame, written as people write it."""
        for text in problems:
            self.found.setdefault((name, text), []).append(frame)

    @property
    def count(self) -> int:
        """Problems times frames."""
        return sum(map(len, self.found.values()))

    @property
    def words(self) -> str:
        """Everything in one line."""
        return together(self.lines)

    @property
    def lines(self) -> list[str]:
        """One sentence for each object and problem, with the frames."""
        return [
            Sentence("{name}, {frames}: {text}", name=name, frames=_frames(frames), text=sentence(text))
            for (name, text), frames in self.found.items()
        ]


def _frames(frames: list[str]) -> Sentence:
    if len(frames) == 1:
        return Sentence("frame {frame}", frame=frames[0])
    return Sentence("{count} frames from {first} to {last}", count=len(frames), first=frames[0], last=frames[-1])
