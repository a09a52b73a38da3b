# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests of this folder inside Blender, on the installed zip.

Use, in an environment with bpy and pytest:
    python run_in_blender.py --zip dist/isochor-….zip [pytest's arguments]
or in a real Blender, whose Python has pytest, with BLENDER_USER_RESOURCES naming an empty folder:
    blender -b --factory-startup --python-exit-code 1 --python run_in_blender.py -- --zip ….zip [pytest's arguments]
"""

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import installed_extension  # noqa: E402


def main() -> int:
    parser = argparse.ArgumentParser(description="Runs the tests inside Blender, on the installed zip.")
    parser.add_argument("--zip", type=Path, required=True, help="the extension that make extension built")
    chosen, rest = parser.parse_known_args(installed_extension.own_arguments())
    installed_extension.isolate()
    installed_extension.install(chosen.zip)
    import bpy
    import pytest

    print(f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}, {chosen.zip.name}", flush=True)
    named = [word for word in rest if not word.startswith("-") and Path(word.split("::")[0]).exists()]
    return int(pytest.main([*rest, f"--rootdir={HERE}", f"--confcutdir={HERE}", *([] if named else [str(HERE)])]))


if __name__ == "__main__":
    installed_extension.leave(main())
