# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume of one mesh over a range of frames, before and after the correction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .curve_image import percent_of

Values = NDArray[np.float64]


class Sample(NamedTuple):
    """Signed volumes of one frame in cubic units of the object's own space; NaN where they cannot be known."""

    frame: int
    target: float
    before: float
    after: float


UNKNOWN = (float("nan"),) * 3
"""Target, before and after of a frame that cannot be measured."""


@dataclass(frozen=True)
class VolumeCurve:
    """Rows of one length: ``frames`` rising, and of each frame the ``target`` volume, that ``before`` the correction,
    as the animator's lattice deforms the mesh, and that ``after`` it."""

    frames: NDArray[np.int32]
    target: Values
    before: Values
    after: Values

    @classmethod
    def of(cls, samples: Sequence[Sample]) -> "VolumeCurve":
        """From one sample a frame."""
        frames, *volumes = (list(column) for column in zip(*samples, strict=True))
        return cls(np.array(frames, np.int32), *(np.array(column, np.float64) for column in volumes))

    @classmethod
    def from_mapping(cls, kept: Mapping[str, Any]) -> "VolumeCurve":
        """From what ``mapping`` gave."""
        volumes = (np.array(kept[name], np.float64) for name in ("target", "before", "after"))
        return cls(np.array(kept["frames"], np.int32), *volumes)

    def mapping(self) -> dict[str, list[int] | list[float]]:
        """Plain lists by name, to be kept in a file."""
        return {
            "frames": [int(frame) for frame in self.frames],
            "target": [float(volume) for volume in self.target],
            "before": [float(volume) for volume in self.before],
            "after": [float(volume) for volume in self.after],
        }

    @property
    def is_known(self) -> bool:
        """Whether any frame could be measured."""
        return bool(np.isfinite(self.after_percent).any())

    @property
    def before_percent(self) -> Values:
        """Before the correction, in percent of the target."""
        return percent_of(self.before, self.target)

    @property
    def after_percent(self) -> Values:
        """After the correction, in percent of the target."""
        return percent_of(self.after, self.target)

    @property
    def signature(self) -> bytes:
        """Tells one curve from another."""
        return b"".join(values.tobytes() for values in (self.frames, self.target, self.before, self.after))


def farthest(percents: Values) -> float:
    """The percentage that is farthest from 100, or NaN where none is known."""
    known = percents[np.isfinite(percents)]
    return float(known[np.argmax(np.abs(known - 100.0))]) if len(known) else float("nan")
