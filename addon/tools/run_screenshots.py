# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes pictures of the real Blender window, on a display of its own, into out/gallery/screenshots.

Use: python run_screenshots.py. Blender is that of the Debian tree of blender_root, with the built extension installed.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import blenders
import build_extension
import system_packages
from workspace import OUT, ROOT, Unavailable, as_program, run, say

SCRIPT = ROOT / "addon" / "demo" / "screenshots.py"
PLACE = OUT / "gallery" / "screenshots"
WIDTH, HEIGHT = 1600, 1000


def main() -> None:
    blender = blenders.in_root()
    zip_file = build_extension.extension()
    system_packages.install(system_packages.GROUPS["window"])
    geometry = ["0", "0", str(WIDTH), str(HEIGHT)]
    started = [blender.program, "--factory-startup", "--gpu-backend", "opengl", "--window-geometry", *geometry]
    say(f"pictures of {blender.name}'s window, into {PLACE}")
    with display() as name:
        environment = {**blender.isolation("screenshots"), "ISOCHOR_DISPLAY": name}
        run([*started, "--python", SCRIPT, "--", "--zip", zip_file, "--out", PLACE], environment)


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


if __name__ == "__main__":
    as_program(main)
