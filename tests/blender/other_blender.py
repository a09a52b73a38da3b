# SPDX-License-Identifier: GPL-3.0-or-later
"""Another Blender of the same kind, in a process and a user folder of its own: without the add-on, or with another."""

import os
import subprocess
import sys
from pathlib import Path

from installed_extension import ISOLATION

HERE = Path(__file__).resolve().parent
LIMIT_S = 300.0


def command(script: Path, *arguments: object) -> list[str]:
    """The command that runs a script with this Blender; the script reads installed_extension.own_arguments()."""
    words = [str(argument) for argument in arguments]
    if bpy_program():
        factory = ["--background", "--factory-startup", "--python-exit-code", "1", "--python"]
        return [bpy_program(), *factory, str(script), "--", *words]
    return [sys.executable, str(script), *words]


def bpy_program() -> str:
    """Path of the real Blender that runs this, empty in the bpy module."""
    import bpy

    return str(bpy.app.binary_path)


def run(text: str, folder: Path, *arguments: object, with_extension: bool = False) -> str:
    """Runs Python source in a new process and returns what it printed; AssertionError where it failed.

    ``text`` finds bpy imported, tests/blender importable and the arguments, as words, in ``arguments``. Its user
    folder is an empty one in ``folder``; ``with_extension`` takes this process's own, where the extension is installed,
    and enables it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    script = folder / "script.py"
    script.write_text(PREAMBLE.format(here=str(HERE), enable=with_extension) + text + EPILOGUE, encoding="utf-8")
    user = os.environ[ISOLATION] if with_extension else str(folder / "user")
    Path(user).mkdir(exist_ok=True)
    environment = {**os.environ, ISOLATION: user}
    done = subprocess.run(command(script, *arguments), env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    said = done.stdout[-4000:] + done.stderr[-4000:]
    assert done.returncode == 0, said
    assert "Traceback" not in done.stderr, said
    return done.stdout


PREAMBLE = """\
import sys
sys.path.insert(0, {here!r})
import installed_extension
arguments = installed_extension.own_arguments()
import bpy
if {enable!r}:
    import addon_utils
    addon_utils.enable(installed_extension.MODULE)
else:
    assert installed_extension.MODULE not in bpy.context.preferences.addons
"""
# bpy 4.5 hangs in its own clean-up where a Python handler is registered.
EPILOGUE = """
installed_extension.leave(0)
"""
