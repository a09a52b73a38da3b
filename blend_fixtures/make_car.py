# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes Ferrier's car and its crash from nothing, headless: `python make_car.py --zip ZIP [--output FILE]
[--strip PNG]`.

Needs the bpy module and the built extension, whose operators add the four lattices and tie them as an animator would.
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
    command_arguments,
    enable_cycles,
    install_extension,
    run_and_leave,
)

os.environ.setdefault(USER_RESOURCES, tempfile.mkdtemp(prefix="isochor-car-"))

import bpy  # noqa: E402
from car_crash import Crash  # noqa: E402
from figure_stage import View, set_view  # noqa: E402
from frame_strip import render_strip  # noqa: E402

STRIP_FRAMES = (1, 6, 10, 12, 14, 18)
VIEW = View(turn=-40.0, rise=19.0, height=0.55, distance=15.0, size=(400, 280))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--output", type=Path, help="the .blend file to write")
    parser.add_argument("--strip", type=Path, help="a picture of several frames to write")
    chosen = parser.parse_args(command_arguments())
    install_extension(chosen.zip.resolve())
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    enable_cycles()
    Crash(bpy.context.scene)
    if chosen.output:
        bpy.ops.wm.save_as_mainfile(filepath=str(chosen.output.resolve()), compress=True)
    if chosen.strip:
        set_view(bpy.context.scene, VIEW)
        render_strip(STRIP_FRAMES, chosen.strip)


if __name__ == "__main__":
    run_and_leave(main)
