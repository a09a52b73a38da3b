# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.measure_volume."""

from collections.abc import Generator

import bpy

from ..core import problem
from ..core.problem import Problem
from ..core.volume_curve import VolumeCurve, farthest
from ..core.words import Sentence, named
from ..tool import volume_curve, words
from .choosing import chosen_modifiers
from .stepping import Stepping


class ISOCHOR_OT_measure_volume(Stepping, bpy.types.Operator):
    """Measure the volume over a range of frames, as the lattice alone deforms the mesh and as corrected, and draw it
    as a curve in the sidebar. Esc breaks it off"""

    _broken_off = "Broken off: nothing was kept"
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
            return self.run(context, self._measuring(context))
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self._with_progress = not bpy.app.background
        return self.execute(context)

    def how_far(self, step: int) -> tuple[float, str]:
        """From the number of frames that are measured."""
        text = Sentence("Measuring the volume: frame {frame}. Esc: break off", frame=self._frames[step - 1])
        return step / len(self._frames), text

    def finished(self, found: list[VolumeCurve]) -> set[str]:
        """Keeps the curves, and says the worst of each."""
        for (obj, modifier), curve in zip(self._pairs, found, strict=True):
            volume_curve.keep(modifier, curve)
            self.report({"INFO"}, words.reported(named(obj.name, summary(curve))))
        return {"FINISHED"}

    def _measuring(self, context: bpy.types.Context) -> Generator[int, None, list[VolumeCurve]]:
        """The work to do; raises Problem where it cannot be done at all."""
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
        return volume_curve.measure(scene, context.view_layer, self._pairs, self._frames)


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
