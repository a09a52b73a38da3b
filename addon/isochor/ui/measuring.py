# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.measure_volume."""

from collections.abc import Generator
from time import perf_counter

import bpy

from ..core import problem
from ..core.problem import Problem
from ..core.volume_curve import VolumeCurve, farthest
from ..core.words import Sentence, named
from ..tool import volume_curve, words
from .choosing import chosen_modifiers

PATIENCE = 0.1
"""Seconds of measuring between two looks at whether Esc was pressed."""


class ISOCHOR_OT_measure_volume(bpy.types.Operator):
    """Measure the volume over a range of frames, as the lattice alone deforms the mesh and as corrected, and draw it
    as a curve in the sidebar. Esc breaks it off"""

    bl_idname = "isochor.measure_volume"
    bl_label = "Measure Volume"
    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(
        name="Start", description="First frame; the scene's where it is not given", options={"SKIP_SAVE"}
    )
    frame_end: bpy.props.IntProperty(
        name="End", description="Last frame; the scene's where it is not given", options={"SKIP_SAVE"}
    )
    step: bpy.props.IntProperty(
        name="Step",
        description="Frames from one measured frame to the next",
        default=1,
        min=1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set("Select a mesh with a Volume Lattice first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            self._begin(context)
            while True:
                next(self._measuring)
        except StopIteration as end:
            return self._keep(end.value)
        except Problem as trouble:
            return self._refuse(trouble)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            self._begin(context)
        except Problem as trouble:
            return self._refuse(trouble)
        manager = context.window_manager
        self._timer = manager.event_timer_add(0.001, window=context.window)
        manager.progress_begin(0, len(self._frames))
        context.workspace.status_text_set(words.shown("Measuring the volume. Esc: break off"))
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, "Broken off: nothing was kept")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            self._advance(context)
        except StopIteration as end:
            self._end_modal(context)
            return self._keep(end.value)
        except Problem as trouble:
            self._end_modal(context)
            return self._refuse(trouble)
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Shows the frame as before; also where Blender ends the operator, as with its window."""
        self._measuring.close()
        self._end_modal(context)

    def _begin(self, context: bpy.types.Context) -> None:
        """Gets ready to measure; raises Problem where that cannot be."""
        scene, given = context.scene, self.properties.is_property_set
        if not given("frame_start"):
            self.frame_start = scene.frame_start
        if not given("frame_end"):
            self.frame_end = scene.frame_end
        if self.frame_end < self.frame_start:
            raise Problem(problem.ends_before(self.frame_start, self.frame_end))
        self._pairs = chosen_modifiers(context)
        self._frames = range(self.frame_start, self.frame_end + 1, self.step)
        volume_curve.require_measurable(self._pairs)
        self._measuring: Generator[int, None, list[VolumeCurve]] = volume_curve.measure(
            scene, context.view_layer, self._pairs, self._frames
        )

    def _advance(self, context: bpy.types.Context) -> None:
        until = perf_counter() + PATIENCE
        done = next(self._measuring)
        while perf_counter() < until:
            done = next(self._measuring)
        context.window_manager.progress_update(done)
        text = Sentence("Measuring the volume: frame {frame}. Esc: break off", frame=self._frames[done - 1])
        context.workspace.status_text_set(words.shown(text))

    def _end_modal(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _keep(self, curves: list[VolumeCurve]) -> set[str]:
        for (obj, modifier), curve in zip(self._pairs, curves, strict=True):
            volume_curve.keep(modifier, curve)
            self.report({"INFO"}, words.reported(named(obj.name, summary(curve))))
        return {"FINISHED"}

    def _refuse(self, trouble: Problem) -> set[str]:
        self.report({"ERROR"}, words.reported(trouble.sentence))
        return {"CANCELLED"}


def summary(curve: VolumeCurve) -> str:
    """The worst frames in one line."""
    plain, kept = farthest(curve.before_percent) - 100.0, farthest(curve.after_percent) - 100.0
    return Sentence("lattice alone {plain} %, corrected {kept} %", plain=f"{plain:+.1f}", kept=f"{kept:+.1e}")


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_measure_volume)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_measure_volume)
