# SPDX-License-Identifier: GPL-3.0-or-later
"""Running a bake from an operator: straight through, or in a window frame by frame with progress until Esc."""

from collections.abc import Callable, Generator
from time import perf_counter
from typing import TYPE_CHECKING

import bpy

from ..core.problem import Problem
from ..core.words import Sentence
from ..tool import words
from ..tool.frames import Step

Bake = Generator[Step, None, list[str]]
"""What a bake is: an iterator that yields after every frame, returns warnings in plain words, raises Problem where it
cannot be done, and where it is closed before its end leaves everything as it was."""
WAIT_S = 0.001
PATIENCE_S = 0.1
"""Between two looks at whether Esc was pressed, each of which draws the window anew; a frame may take longer."""


class Stepping:
    """For operators that bake: call ``run`` with the bake, from ``execute``."""

    _bake: Bake | None = None
    _timer: bpy.types.Timer | None = None
    _with_progress = False
    if TYPE_CHECKING:
        report: Callable[[set[str], str], None]

    def run(self, context: bpy.types.Context, bake: Bake) -> set[str]:
        """To the end at once, or from a dialog with progress."""
        if self._with_progress and context.window is not None:
            self._bake = bake
            self._timer = context.window_manager.event_timer_add(WAIT_S, window=context.window)
            context.window_manager.progress_begin(0.0, 1.0)
            context.window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        done = None
        while done is None:
            done = self._step(bake)
        return done

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Some frames each time that the timer ticks; Esc ends it."""
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, "Bake cancelled: nothing was written")
            return {"CANCELLED"}
        if event.type != "TIMER" or self._bake is None:
            return {"RUNNING_MODAL"}
        started, done = perf_counter(), None
        while done is None and perf_counter() - started < PATIENCE_S:
            done = self._step(self._bake, context)
        if done is None:
            return {"RUNNING_MODAL"}
        self._take_down(context)
        return done

    def cancel(self, context: bpy.types.Context) -> None:
        """Leaves everything as it was."""
        if self._bake is not None:
            self._bake.close()
        self._take_down(context)

    def _step(self, bake: Bake, context: bpy.types.Context | None = None) -> set[str] | None:
        """One frame; how it ended, once it has."""
        try:
            step = next(bake)
        except StopIteration as end:
            for text in end.value or ():
                self.report({"WARNING"}, words.reported(text))
            return {"FINISHED"}
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if context is not None:
            context.window_manager.progress_update(step.done / step.total)
            context.workspace.status_text_set(words.shown(how_far(step)))
        return None

    def _take_down(self, context: bpy.types.Context) -> None:
        self._bake = None
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            context.workspace.status_text_set(None)
            self._timer = None


def how_far(step: Step) -> str:
    """What the status bar says."""
    return Sentence(
        "Baking frame {frame}: {done} of {total}.   Esc: cancel, nothing is written",
        frame=step.moment.words,
        done=step.done,
        total=step.total,
    )
