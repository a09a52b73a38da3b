# SPDX-License-Identifier: GPL-3.0-or-later
"""Records what leaves our modifiers of several objects in one walk over the frames, with flat memory."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.tally import Tally
from ..core.words import Sentence
from . import frames

Sink = Callable[[NDArray[np.float32]], object]
"""Takes the (V, 3) positions of the next moment, in object space."""
Opening = Callable[[frames.Target, int], AbstractContextManager[Sink]]
"""Makes the sink of an object with that many vertices; its context is left with an exception where all is in vain."""


def record(
    context: bpy.types.Context,
    chosen: list[frames.Target],
    when: list[frames.Moment],
    opening: Opening,
    tally: Tally,
    strict: bool = False,
    anchor: frames.Moment | None = None,
) -> Iterator[frames.Step]:
    """Hands each moment of each object to its sink, and notes problems in the tally. Closing the iterator before its
    end, an exception in it, or a Problem that it raises, as where the number of vertices changes from frame to frame,
    leaves the sinks with an exception, so that they keep nothing. So does a problem in any frame where ``strict``,
    after the last frame."""
    with ExitStack() as stack:
        steps = stack.enter_context(closing(frames.walk(context, chosen, when, anchor)))
        sinks: dict[str, tuple[int, Sink]] = {}
        for done, moment in enumerate(steps, 1):
            for target in chosen:
                positions = frames.leaving(target, context)
                name = target.obj.name
                if name not in sinks:
                    sinks[name] = len(positions), stack.enter_context(opening(target, len(positions)))
                _require_count(name, moment, len(positions), sinks[name][0], when[0])
                sinks[name][1](positions)
                tally.add(name, moment.words, target.problems())
            yield frames.Step(done, len(when), moment)
        if strict and tally.count:
            raise problem.Problem(Sentence("Nothing was written. {problems}", problems=tally.words))


def _require_count(name: str, moment: frames.Moment, found: int, first: int, start: frames.Moment) -> None:
    if found == 0:
        raise problem.Problem(
            Sentence(
                "“{name}” has no vertices in frame {frame}: there is nothing to bake. Correct what removes them.",
                name=name,
                frame=moment.words,
            )
        )
    if found != first:
        raise problem.Problem(
            Sentence(
                "“{name}” has {first} vertices in frame {start} and {found} in frame {frame}: a bake needs the same"
                " in every frame. Switch off what adds or removes vertices before Volume Lattice.",
                name=name,
                first=first,
                start=start.words,
                found=found,
                frame=moment.words,
            )
        )
