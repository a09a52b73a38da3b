# SPDX-License-Identifier: GPL-3.0-or-later
"""Running long work from an operator: straight through, or in a window bit by bit with progress until Esc."""

from collections.abc import Callable, Generator
from time import perf_counter
from typing import TYPE_CHECKING, Any

import bpy

from ..core.problem import Problem
from ..core.words import Sentence
from ..tool import words
from ..tool.frames import Step

Work = Generator[Any, None, Any]
"""An iterator that yields after every step, returns what was found, raises Problem where it cannot be done, and where
it is closed before its end leaves everything as it was."""
Bake = Generator[Step, None, list[str]]
"""Work that returns warnings in plain words."""
WAIT_S = 0.001
PATIENCE_S = 0.1
"""Between two looks at whether Esc was pressed, each of which draws the window anew; a step may take longer."""


class Stepping:
    """For operators that work long: call ``run`` with the work, from ``execute``; from ``invoke`` set
    ``_with_progress`` before. Steps and end are those of a bake unless ``how_far`` and ``finished`` say otherwise."""

    _work: Work | None = None
    _timer: bpy.types.Timer | None = None
    _with_progress = False
    _broken_off = "Bake cancelled: nothing was written"
    if TYPE_CHECKING:
        report: Callable[[set[str], str], None]

    def how_far(self, step: Any) -> tuple[float, str]:
        """What is done, from 0 to 1, and what the status bar says."""
        return step.done / step.total, baking_words(step)

    def finished(self, found: Any) -> set[str]:
        """Takes what the work returned; how the operator ends."""
        for text in found or ():
            self.report({"WARNING"}, words.reported(text))
        return {"FINISHED"}

    def run(self, context: bpy.types.Context, work: Work) -> set[str]:
        """To the end at once, or, the first time after ``invoke``, with progress."""
        with_progress, self._with_progress = self._with_progress, False
        if with_progress and context.window is not None:
            self._work = work
            self._timer = context.window_manager.event_timer_add(WAIT_S, window=context.window)
            context.window_manager.progress_begin(0.0, 1.0)
            context.window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        done = None
        while done is None:
            done = self._step(work)
        return done

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Some steps each time that the timer ticks; Esc ends it."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, self._broken_off)
            return {"CANCELLED"}
        if event.type != "TIMER" or self._work is None:
            return {"RUNNING_MODAL"}
        until = perf_counter() + PATIENCE_S
        done = self._step(self._work, context)
        while done is None and perf_counter() < until:
            done = self._step(self._work, context)
        if done is None:
            return {"RUNNING_MODAL"}
        self._take_down(context)
        return done

    def cancel(self, context: bpy.types.Context) -> None:
        """Leaves everything as it was; also where Blender ends the operator, as with its window."""
        if self._work is not None:
            self._work.close()
        self._take_down(context)

    def _step(self, work: Work, context: bpy.types.Context | None = None) -> set[str] | None:
        """One step; how it ended, once it has."""
        try:
            step = next(work)
        except StopIteration as end:
            return self.finished(end.value)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if context is not None:
            share, text = self.how_far(step)
            context.window_manager.progress_update(share)
            context.workspace.status_text_set(words.shown(text))
        return None

    def _take_down(self, context: bpy.types.Context) -> None:
        self._work = None
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            context.workspace.status_text_set(None)
            self._timer = None


def baking_words(step: Step) -> str:
    """What the status bar says of a bake."""
    return Sentence(
        "Baking frame {frame}: {done} of {total}.   Esc: cancel, nothing is written",
        frame=step.moment.words,
        done=step.done,
        total=step.total,
    )
