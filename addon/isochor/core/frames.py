# SPDX-License-Identifier: GPL-3.0-or-later
"""Computed frames kept in memory, so that a frame seen before costs no second solve.

A frame is found by a quick number over what tells frames apart, and taken only where its request equals the one asked
for in every value: two frames are never mistaken for each other. A frame is kept when it is computed for the second
time: memory that was never used before costs time (5 to 30 % of a frame, as measured), which a shot played once would
pay for nothing. When memory runs out, the frame that was used longest ago goes first.
"""

from collections import Counter, OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from .request import Request
    from .solver import Outcome

SAMPLED = 64
"""Vertices that tell one incoming shape from another when looking a frame up; equality is checked on all of them."""

REMEMBERED = 10_000
"""Frames seen once that are told from new ones."""

Key = tuple[object, int]
"""Whose frame it is, and the quick number."""


@dataclass(frozen=True)
class Frame:
    """What was asked for and what came out."""

    request: "Request"
    outcome: "Outcome"

    def arrays(self) -> list[NDArray[Any]]:
        """Everything of size that is kept with it, each array once."""
        request, report = self.request, self.outcome.report
        solved = None if report.result is None else report.result.vertices
        asked = request.positions, request.influence, request.control, request.stiffness, request.grid.weights
        every = (*asked, self.outcome.vertices, solved, report.control)
        return list({id(array): array for array in every if array is not None}.values())


class Frames:
    """Frames of all modifiers together, within ``limit`` bytes; with 0 none is kept. Not thread-safe.

    ``used`` counts an array that several frames share, as the positions of a mesh that does not change, once.
    """

    def __init__(self, limit: int = 0) -> None:
        self.limit = limit
        self.used = 0
        self._frames: OrderedDict[Key, Frame] = OrderedDict()
        self._seen: OrderedDict[Key, None] = OrderedDict()
        self._holders: Counter[int] = Counter()

    def __len__(self) -> int:
        return len(self._frames)

    def find(self, owner: object, request: "Request") -> "Outcome | None":
        """The outcome kept for an equal request of the same owner."""
        if not self._frames:
            return None
        key = (owner, quick_number(request))
        frame = self._frames.get(key)
        if frame is None or not request.same_as(frame.request):
            return None
        self._frames.move_to_end(key)
        return frame.outcome

    def keep(self, owner: object, request: "Request", outcome: "Outcome") -> None:
        """Keeps a frame seen before, and lets go of the oldest ones where they no longer fit into the limit."""
        if self.limit <= 0:
            return
        key = (owner, quick_number(request))
        if not self._is_second(key):
            return
        self._drop(key)
        self._frames[key] = Frame(request, outcome)
        for array in self._frames[key].arrays():
            if not self._holders[id(array)]:
                self.used += array.nbytes
            self._holders[id(array)] += 1
        self._shrink()

    def resize(self, limit: int) -> None:
        """Sets the limit, and lets go of the oldest frames that are beyond it."""
        self.limit = limit
        self._shrink()

    def forget(self, owner: object) -> None:
        """Lets go of all frames of one owner."""
        for key in [key for key in self._frames if key[0] is owner]:
            self._drop(key)
        for key in [key for key in self._seen if key[0] is owner]:
            del self._seen[key]

    def clear(self) -> None:
        """Lets go of everything."""
        self._frames.clear()
        self._seen.clear()
        self._holders.clear()
        self.used = 0

    def _is_second(self, key: Key) -> bool:
        known = key in self._seen
        self._seen[key] = None
        self._seen.move_to_end(key)
        if len(self._seen) > REMEMBERED:
            self._seen.popitem(last=False)
        return known

    def _shrink(self) -> None:
        while self.used > self.limit:
            self._drop(next(iter(self._frames)))

    def _drop(self, key: Key) -> None:
        frame = self._frames.pop(key, None)
        for array in [] if frame is None else frame.arrays():
            self._holders[id(array)] -= 1
            if not self._holders[id(array)]:
                del self._holders[id(array)]
                self.used -= array.nbytes


def quick_number(request: "Request") -> int:
    """Differs, all but certainly, between the frames of a shot; costs some microseconds whatever the mesh's size."""
    positions = request.positions
    sample = positions[:: max(1, len(positions) // SAMPLED)]
    frame = b"" if request.frame is None else request.frame.tobytes()
    transform = request.grid.to_object.tobytes()
    targets = b"" if request.pins is None else request.pins.targets.tobytes()
    numbers = (request.control.tobytes(), sample.tobytes(), frame, transform, targets)
    return hash((numbers, request.rest_volume, request.settings))
