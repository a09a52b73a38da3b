# SPDX-License-Identifier: GPL-3.0-or-later
"""An isolated Blender with the built extension installed, whether Blender is the bpy module or the real program."""

import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path

USER_RESOURCES = "BLENDER_USER_RESOURCES"
EXTENSION = "bl_ext.user_default.isochor"


class DemoError(Exception):
    """Something the reader of the message can put right; printed without a traceback."""


def blender_program() -> str | None:
    """Path of the Blender program that runs this Python; None under a plain Python, with or without the bpy module."""
    bpy = sys.modules.get("bpy")
    return bpy.app.binary_path if bpy and bpy.app.binary_path else None


def command_arguments() -> list[str]:
    """What was given to the script: after `--` in the real Blender, after the script's name in a plain Python."""
    if blender_program():
        return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    return sys.argv[1:]


def python_command(script: Path, arguments: Sequence[str]) -> list[str]:
    """Command that runs `script` as this one runs: in the same Blender program, or in the same Python."""
    program = blender_program()
    if program:
        started: list[str | Path] = [
            program,
            "--background",
            "--factory-startup",
            "--python-exit-code",
            "1",
            "--python",
            script,
            "--",
        ]
    else:
        started = [sys.executable, "-u", script]
    return [str(word) for word in (*started, *arguments)]


def isolated_environment(folder: Path) -> dict[str, str]:
    """Environment for a Blender that keeps preferences and extensions in `folder` and touches no other."""
    folder.mkdir(parents=True, exist_ok=True)
    return {**os.environ, USER_RESOURCES: str(folder)}


def install_extension(zip_path: Path) -> None:
    """Installs and enables the built extension; raises DemoError unless Blender is isolated and the install worked."""
    import bpy

    if USER_RESOURCES not in os.environ:
        raise DemoError(f"{USER_RESOURCES} is not set: refusing to install {zip_path} into your own Blender.")
    outcome = bpy.ops.extensions.package_install_files(
        repo="user_default", filepath=str(zip_path), enable_on_install=True
    )
    if outcome != {"FINISHED"} or EXTENSION not in bpy.context.preferences.addons:
        raise DemoError(f"Blender {bpy.app.version_string} did not enable {zip_path}: see its messages.")


def enable_cycles() -> None:
    """The bpy module does not always start with Cycles enabled."""
    import bpy

    if "cycles" not in bpy.context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="cycles")


def run_and_leave(main: Callable[[], None]) -> None:
    """Runs `main` and ends the process with its outcome at once: bpy 4.5 hangs in the usual way out."""
    status = 1
    try:
        main()
        status = 0
    except DemoError as error:
        print(f"error: {error}", file=sys.stderr)
    except SystemExit as request:
        status = request.code if isinstance(request.code, int) else int(request.code is not None)
    finally:
        if sys.exception():
            traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
