# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a bouncing jelly from nothing, headless: `python make_jelly.py --zip ZIP [--output FILE] [--strip PNG]`.

Needs the bpy module and the built extension, whose operators add the lattice and let it fall as an animator would.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon" / "demo")]

from blender_session import (  # noqa: E402
    USER_RESOURCES,
    DemoError,
    command_arguments,
    enable_cycles,
    install_extension,
    run_and_leave,
)

os.environ.setdefault(USER_RESOURCES, tempfile.mkdtemp(prefix="isochor-jelly-"))

import bpy  # noqa: E402
from ball_object import make_ball  # noqa: E402
from frame_strip import render_strip  # noqa: E402
from mathutils import Vector  # noqa: E402
from stage import set_stage  # noqa: E402
from volume_lattice import find_volume_lattice, get_input  # noqa: E402

FRAME_START, FRAME_END = 1, 96
HEIGHT = 2.6  # of the ball's middle; its radius is 1
SIDEWAYS = (0.15, 0.0, 0.0)
STRIP_FRAMES = (1, 12, 16, 19, 23, 28, 34, 40, 48, 90)
STRIP_SIZE = (240, 280)
LATTICE_POINTS = (4, 4, 4)


def make_scene(**settings: object) -> bpy.types.Object:
    """Stage, ball and simulated lattice, in the empty file that is open; returns the ball. ``settings`` go to
    isochor.simulate."""
    scene = bpy.context.scene
    scene.name = "Jelly"
    set_stage(scene)
    scene.camera.location = (0.0, -14.0, 3.6)
    scene.camera.rotation_euler = (Vector((0, 0, 1.7)) - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.render.fps, scene.render.fps_base = 24, 1.0
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    scene.frame_set(FRAME_START)
    ball = make_ball()
    ball.location.z = HEIGHT
    scene.collection.objects.link(ball)
    bpy.context.view_layer.objects.active = ball
    ball.select_set(True)
    bpy.context.view_layer.update()
    finished(bpy.ops.isochor.add(resolution=LATTICE_POINTS), "isochor.add")
    finished(
        bpy.ops.isochor.simulate(**{"velocity": SIDEWAYS, "ground_object": "Ground", **settings}), "isochor.simulate"
    )
    return ball


def finished(outcome: set[str], operator: str) -> None:
    """Raises DemoError unless the operator did its work."""
    if outcome != {"FINISHED"}:
        raise DemoError(f"{operator} answered {outcome}, expected FINISHED.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--output", type=Path, help="where to save the scene")
    parser.add_argument("--strip", type=Path, help="where to save some frames side by side")
    chosen = parser.parse_args(command_arguments())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    enable_cycles()
    install_extension(chosen.zip.resolve())
    ball = make_scene()
    lattice = get_input(find_volume_lattice(ball), "Lattice")
    print(f"{lattice.name}: {len(lattice.data.shape_keys.key_blocks)} frames")
    if chosen.output:
        bpy.ops.wm.save_as_mainfile(filepath=str(chosen.output.resolve()), compress=True, copy=True)
    if chosen.strip:
        bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = STRIP_SIZE
        render_strip(STRIP_FRAMES, chosen.strip.resolve())


if __name__ == "__main__":
    run_and_leave(main)
