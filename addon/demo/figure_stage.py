# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage of the figures: plain ground, and camera and light turned about the model (bpy)."""

from dataclasses import dataclass
from math import cos, radians, sin

import bpy
from mathutils import Matrix, Vector
from stage import tint

GROUND = (0.56, 0.545, 0.52)
SAMPLES = 16
FAR = 12.0
"""Factor on the ground's size: the horizon is above the picture then."""


@dataclass(frozen=True)
class View:
    """Where the camera looks from and how large the picture is. ``turn`` and ``rise`` in degrees: about the model, 0 is
    from -y, and above the horizon; ``height``: of the place looked at."""

    turn: float
    rise: float
    height: float
    distance: float = 12.0
    lens: float = 85.0
    size: tuple[int, int] = (392, 360)


def set_view(scene: bpy.types.Scene, view: View) -> None:
    """Turns the camera and the lights of the stage, and lays the plain ground."""
    about = Matrix.Rotation(radians(view.turn), 4, "Z")
    target = Vector((0.0, 0.0, view.height))
    away = Vector((0.0, -cos(radians(view.rise)), sin(radians(view.rise))))
    scene.camera.location = target + about @ (view.distance * away)
    scene.camera.rotation_euler = (target - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera.data.lens = view.lens
    for lamp in (obj for obj in scene.objects if obj.type == "LIGHT"):
        lamp.matrix_world = about @ lamp.matrix_world
    ground = bpy.data.objects["Ground"]
    ground.data.materials[0] = tint("Plain Ground", GROUND)
    ground.scale = (FAR, FAR, 1.0)
    scene.render.resolution_x, scene.render.resolution_y = view.size
    scene.cycles.samples = SAMPLES
    bpy.context.view_layer.update()
