# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the scripts of tests/window in a real Blender window, with the built extension installed.

Use: python run_window_tests.py. They take some minutes, and leave what they saw in out/window-tests.
"""

import build_extension
import real_window
from workspace import OUT, ROOT, as_program

TESTS = ROOT / "tests" / "window"
PLACE = OUT / "window-tests"


def main() -> None:
    zip_file = build_extension.extension()
    for script in sorted(TESTS.glob("live_*.py")):
        real_window.run_in_window(script.stem, script, "--zip", zip_file, "--out", PLACE / script.stem)


if __name__ == "__main__":
    as_program(main)
