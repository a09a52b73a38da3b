# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the bouncing ball into out/bouncing-ball with the built extension zip, again only when something changed.

Use: python run_demo.py.
"""

import shutil
import subprocess
from pathlib import Path

import blenders
import build_extension
import environments
from workspace import OUT, ROOT, Unavailable, fail, fingerprint, is_fresh, run, say

SCRIPT = ROOT / "addon" / "demo" / "bouncing_ball.py"
SOURCES = [ROOT / "addon" / "demo", ROOT / "blend_fixtures"]
PLACE = OUT / "bouncing-ball"


def main() -> None:
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    stamp = PLACE / ".rendered"
    digest = fingerprint([*SOURCES, zip_file], blender.name)
    if not is_fresh(stamp, digest):
        say(f"rendering the bouncing ball in {blender.name}")
        shutil.rmtree(PLACE, ignore_errors=True)
        PLACE.mkdir(parents=True)
        run(_command(blender, zip_file), blender.isolation("demo"))
        stamp.write_text(digest)
    say(f"the bouncing ball is in {PLACE.relative_to(ROOT)}/ (to render it again: make clean-demo demo)")
    for file in sorted(file for file in PLACE.iterdir() if file.is_file() and not file.name.startswith(".")):
        print(f"  {file.relative_to(ROOT)}")


def _command(blender: blenders.Blender, zip_file: Path) -> list[str]:
    command = blender.command(SCRIPT, "--zip", zip_file, "--out", PLACE)
    return command if blender.has_pictures else [*command, "--pictures-python", str(environments.python("pictures"))]


if __name__ == "__main__":
    try:
        main()
    except (Unavailable, subprocess.CalledProcessError) as reason:
        fail(str(reason))
