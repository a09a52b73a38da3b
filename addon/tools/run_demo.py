# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the bouncing ball into out/bouncing-ball with the built extension zip; quick where nothing changed.

Use: python run_demo.py.
"""

from pathlib import Path

import blenders
import build_extension
import environments
from workspace import OUT, ROOT, as_program, run, say

SCRIPT = ROOT / "addon" / "demo" / "bouncing_ball.py"
PLACE = OUT / "bouncing-ball"


def main() -> None:
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    say(f"the bouncing ball, in {blender.name}")
    run(_command(blender, zip_file), blender.isolation("demo"))


def _command(blender: blenders.Blender, zip_file: Path) -> list[str]:
    command = blender.command(SCRIPT, "--zip", zip_file, "--out", PLACE)
    return command if blender.has_pictures else [*command, "--pictures-python", str(environments.python("pictures"))]


if __name__ == "__main__":
    as_program(main)
