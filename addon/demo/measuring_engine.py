# SPDX-License-Identifier: GPL-3.0-or-later
"""A render engine that measures instead of painting.

Blender hands a render engine the evaluated scene of each frame. Registered as an engine, this sees exactly the mesh
that Cycles would draw in the same `render(animation=True)`, with nothing assumed about how it came to be.
"""

from typing import ClassVar

import bpy
from surface_measures import SurfaceMeasure, measure_evaluated


class MeasuringEngine(bpy.types.RenderEngine):
    """Measures the object named `object_name` at each rendered frame into `measures`, by frame."""

    bl_idname = "ISOCHOR_MEASURE"
    bl_label = "Measure"

    object_name = ""
    measures: ClassVar[dict[int, SurfaceMeasure]] = {}

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Called by Blender once a frame with the evaluated scene."""
        measured = measure_evaluated(bpy.data.objects[self.object_name], depsgraph)
        self.measures[depsgraph.scene.frame_current] = measured


def measure_animation(scene: bpy.types.Scene, blender_object: bpy.types.Object) -> dict[int, SurfaceMeasure]:
    """SurfaceMeasure of `blender_object` by frame, over the frame range of `scene`, whose settings stay as they are.

    RuntimeError if a frame could not be measured; Blender prints why.
    """
    kept = {name: getattr(scene.render, name) for name in ("engine", "resolution_percentage", "filepath")}
    MeasuringEngine.object_name = blender_object.name
    MeasuringEngine.measures.clear()
    bpy.utils.register_class(MeasuringEngine)
    try:
        scene.render.engine = MeasuringEngine.bl_idname
        scene.render.resolution_percentage = 1
        scene.render.filepath = bpy.app.tempdir + "measure-"
        bpy.ops.render.render(animation=True, scene=scene.name)
    finally:
        for name, value in kept.items():
            setattr(scene.render, name, value)
        bpy.utils.unregister_class(MeasuringEngine)
    missing = set(range(scene.frame_start, scene.frame_end + 1)) - set(MeasuringEngine.measures)
    if missing:
        raise RuntimeError(f"{blender_object.name!r} was not measured at frames {sorted(missing)}; Blender printed why")
    return dict(MeasuringEngine.measures)
