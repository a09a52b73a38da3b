# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a script in a real Blender with a window, on a display that nobody sees.

Blender is that of the Debian tree of blender_root: software OpenGL, so nothing depends on the machine.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import blenders
import system_packages
from workspace import Unavailable, run, say

WIDTH, HEIGHT = 1600, 1000


def run_in_window(purpose: str, script: Path, *arguments: str | Path) -> None:
    """Runs the script, which ends the process itself, and raises CalledProcessError where that fails."""
    blender = blenders.in_root()
    system_packages.install(system_packages.GROUPS["window"])
    geometry = ["0", "0", str(WIDTH), str(HEIGHT)]
    flags = ["--factory-startup", "--gpu-backend", "opengl", "--enable-event-simulate", "--window-geometry", *geometry]
    say(f"{purpose}: {script.name} in {blender.name} with a window")
    with display() as name:
        environment = {**blender.isolation(purpose), "ISOCHOR_DISPLAY": name}
        run([blender.program, *flags, "--python", script, "--", *arguments], environment)


@contextmanager
def display() -> Iterator[str]:
    """The name of an X display that nobody sees, as large as the window."""
    reading, writing = os.pipe()
    size = f"{WIDTH}x{HEIGHT}x24"
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", size, "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[writing], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        with os.fdopen(reading) as answer:
            number = answer.readline().strip()
        if not number:
            raise Unavailable("Xvfb, the display that nobody sees, did not start")
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()
