# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the gallery of the user guide and takes pictures of the real window, into out/gallery, with the built zip.

Use: python run_gallery.py [--publish] [PAGE ...] renders all pages and takes all pictures, or renders those pages that
are named. With --publish the pictures that the documentation shows are then put into docs/pictures.
"""

import argparse
import shutil
import subprocess
from pathlib import Path

import blenders
import build_extension
import environments
import run_screenshots
from workspace import OUT, ROOT, Unavailable, as_program, in_ci, run, say

DEMO = ROOT / "addon" / "demo"
PLACE = OUT / "gallery"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--publish", action="store_true", help="put those shown there into docs/pictures")
    parser.add_argument("pages", nargs="*", metavar="PAGE")
    chosen = parser.parse_args()
    drawing = _render(chosen.pages)
    if not chosen.pages:
        _take_pictures()
    if chosen.publish:
        run([drawing, DEMO / "publish_pictures.py", "--gallery", PLACE, "--docs", ROOT / "docs"])


def _render(pages: list[str]) -> Path:
    """Renders and draws the pages; returns the interpreter that can draw."""
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    say(f"the gallery, in {blender.name}")
    if not pages:
        shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True, exist_ok=True)
    only = ["--only", *pages] if pages else []
    command = blender.command(DEMO / "render_gallery.py", "--zip", zip_file, "--out", PLACE, *only)
    run(command, blender.isolation("gallery"))
    drawing = blender.program if blender.is_wheel else environments.python("pictures")
    run([drawing, DEMO / "draw_gallery.py", "--out", PLACE])
    return drawing


def _take_pictures() -> None:
    """Pictures of the window where a real Blender can be had; else, except in CI, a loud word that they are missing."""
    try:
        run_screenshots.main()
    except (Unavailable, subprocess.CalledProcessError) as reason:
        if in_ci():
            raise
        line = "!" * 100
        print(f"{line}\nNO PICTURES OF THE WINDOW WERE TAKEN: {reason}\n{line}", flush=True)


if __name__ == "__main__":
    as_program(main)
