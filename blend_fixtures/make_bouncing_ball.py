# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes bouncing_ball.blend from nothing, headless: `python make_bouncing_ball.py --zip ZIP [--output FILE]`.

Needs the bpy module (4.5 to write the committed file, so that 4.5 and later open it) and the built extension, whose
operator adds the lattice as an animator would.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon" / "demo")]

from blender_session import USER_RESOURCES, command_arguments, enable_cycles, install_extension, run_and_leave  # noqa: E402

os.environ.setdefault(USER_RESOURCES, tempfile.mkdtemp(prefix="isochor-fixture-"))

import bounce  # noqa: E402
import bpy  # noqa: E402
from ball_object import make_ball  # noqa: E402
from fixture_file import save  # noqa: E402
from lattice_animation import animate, shape_lattice  # noqa: E402
from stage import set_stage  # noqa: E402
from volume_lattice import add_volume_lattice  # noqa: E402

LATTICE_POINTS = (6, 6, 6)


def make_scene() -> None:
    """The whole scene, in the empty file that is open: stage, rig, ball, lattice and bounce."""
    scene = bpy.context.scene
    scene.name = "Bouncing Ball"
    set_stage(scene)
    ball = make_ball()
    scene.collection.objects.link(ball)
    lattice = add_volume_lattice(ball, LATTICE_POINTS)
    rig = _make_rig(scene, ball, lattice)
    shape_lattice(ball, lattice)
    animate(scene, rig, lattice)
    scene.frame_set(bounce.FRAME_START)


def _make_rig(scene: bpy.types.Scene, ball: bpy.types.Object, lattice: bpy.types.Object) -> bpy.types.Object:
    """An empty at the ball's lowest point that carries ball and lattice: at height 0 the ball touches the ground."""
    rig = bpy.data.objects.new("Bounce", None)
    rig.empty_display_type, rig.empty_display_size = "CIRCLE", 1.2
    scene.collection.objects.link(rig)
    lowest = min(vertex.co.z for vertex in ball.data.vertices)
    for carried in (ball, lattice):
        carried.parent = rig
        carried.location.z -= lowest
    bpy.context.view_layer.update()
    return rig


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--output", type=Path, default=HERE / "bouncing_ball.blend")
    chosen = parser.parse_args(command_arguments())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    enable_cycles()
    install_extension(chosen.zip.resolve())
    make_scene()
    save(chosen.output)


if __name__ == "__main__":
    run_and_leave(main)
