# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes pictures of the real Blender window, with the built extension installed, into out/gallery/screenshots.

Use: python run_screenshots.py.
"""

import build_extension
import real_window
from workspace import OUT, ROOT, as_program

SCRIPT = ROOT / "addon" / "demo" / "screenshots.py"
PLACE = OUT / "gallery" / "screenshots"


def main() -> None:
    zip_file = build_extension.extension()
    real_window.run_in_window("screenshots", SCRIPT, "--zip", zip_file, "--out", PLACE)


if __name__ == "__main__":
    as_program(main)
