# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.measure_volume."""

from collections.abc import Generator

import bpy

from ..core.problem import Problem
from ..core.volume_curve import VolumeCurve, farthest
from ..core.words import Sentence, named
from ..tool import volume_curve, words
from .choosing import chosen_modifiers
from .frames import FrameRange
from .stepping import Stepping


class ISOCHOR_OT_measure_volume(Stepping, FrameRange, bpy.types.Operator):
    """Measure the volume over a range of frames, as the lattice alone deforms the mesh and as corrected, and draw it
    as a curve in the sidebar. Esc breaks it off"""

    _broken_off = "Broken off: nothing was kept"
    bl_idname = "isochor.measure_volume"
    bl_label = "Measure Volume"
    bl_options = {"REGISTER", "UNDO"}

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
        first, last = self.take_frames(context.scene)
        self._pairs = chosen_modifiers(context)
        self._frames = range(first, last + 1, self.step)
        volume_curve.require_measurable(self._pairs)
        return volume_curve.measure(context.scene, context.view_layer, self._pairs, self._frames)


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
