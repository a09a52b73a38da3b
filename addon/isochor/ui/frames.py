# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that an operator works on: those given, else the scene's."""

from typing import TYPE_CHECKING

import bpy

from ..core import problem


class FrameRange:
    """For operators with a first and a last frame."""

    if TYPE_CHECKING:
        properties: bpy.types.OperatorProperties

    frame_start: bpy.props.IntProperty(
        name="Start", description="First frame; the scene's where it is not given", options={"SKIP_SAVE"}
    )
    frame_end: bpy.props.IntProperty(
        name="End", description="Last frame; the scene's where it is not given", options={"SKIP_SAVE"}
    )

    def take_frames(self, scene: bpy.types.Scene) -> tuple[int, int]:
        """First and last frame, which the redo panel then shows; raises Problem where they are the wrong way round."""
        if not self.properties.is_property_set("frame_start"):
            self.frame_start = scene.frame_start
        if not self.properties.is_property_set("frame_end"):
            self.frame_end = scene.frame_end
        if self.frame_end < self.frame_start:
            raise problem.Problem(problem.ends_before(self.frame_start, self.frame_end))
        return self.frame_start, self.frame_end
