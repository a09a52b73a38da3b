# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs a built Isochor zip into the Blender that runs this, in a user folder of its own."""

import os
import sys
import tempfile
from pathlib import Path

ISOLATION = "BLENDER_USER_RESOURCES"
MODULE = "bl_ext.user_default.isochor"
ZIP = "ISOCHOR_BUILT_ZIP"
"""Environment variable: the zip that is installed here, for tests that start another Blender."""


def own_arguments() -> list[str]:
    """The arguments meant for the script: all of them under bpy, those behind "--" in a real Blender."""
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]


def isolate() -> None:
    """Keeps the user's own Blender settings out of it; must come before bpy is first imported. A real Blender reads
    them before any script runs, so its caller has to set the variable."""
    if ISOLATION in os.environ:
        return
    if "bpy" in sys.modules:
        raise SystemExit(f"{ISOLATION} is not set: start Blender with it naming an empty folder, or the user's is used")
    os.environ[ISOLATION] = tempfile.mkdtemp(prefix="isochor-blender-")


def install(zip_file: Path) -> None:
    """Installs and enables the zip as a user would; raises RuntimeError where Blender refuses."""
    import bpy

    if not zip_file.is_file():
        raise SystemExit(f"{zip_file} is not there: build it with make extension")
    bpy.ops.extensions.package_install_files(
        repo="user_default", filepath=str(zip_file.resolve()), enable_on_install=True
    )
    os.environ[ZIP] = str(zip_file.resolve())
    if MODULE not in bpy.context.preferences.addons:
        raise SystemExit(f"Blender did not enable {zip_file.name}: its messages above say why")


def leave(code: int) -> None:
    """Ends the process at once: bpy 4.5.15 hangs in its own clean-up where a Python handler is registered."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
