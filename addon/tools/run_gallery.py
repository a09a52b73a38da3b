# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the gallery of the user guide into out/gallery with the built extension zip.

Use: python run_gallery.py [PAGE ...] renders all pages, or those named.
"""

import shutil
import sys

import blenders
import build_extension
import environments
from workspace import OUT, ROOT, as_program, run, say

DEMO = ROOT / "addon" / "demo"
PLACE = OUT / "gallery"


def main(pages: list[str]) -> None:
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    say(f"the gallery, in {blender.name}")
    shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True)
    only = ["--only", *pages] if pages else []
    command = blender.command(DEMO / "render_gallery.py", "--zip", zip_file, "--out", PLACE, *only)
    run(command, blender.isolation("gallery"))
    drawing = blender.program if blender.is_wheel else environments.python("pictures")
    run([drawing, DEMO / "draw_gallery.py", "--out", PLACE])


if __name__ == "__main__":
    as_program(lambda: main(sys.argv[1:]))
