# SPDX-License-Identifier: GPL-3.0-or-later
"""Other Blenders of the kind that runs the tests, in processes of their own: with the extension and without."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
LIMIT_S = 300


def run_script(script: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Runs Python text in a new Blender that has no extension; ``words`` are its sys.argv[1:]."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "script.py"
        place.write_text(f"import os, sys\nsys.argv = ['script', *{list(words)!r}]\n{script}\nos._exit(0)\n")
        return _finished(_python(place), {"BLENDER_USER_RESOURCES": folder})


def start_command(*words: object) -> subprocess.Popen[str]:
    """Begins `blender --command isochor …` in a new process, its output piped."""
    return subprocess.Popen(_command(*words), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=_env({}))


def run_command(*words: object) -> subprocess.CompletedProcess[str]:
    """Runs `blender --command isochor …` in a new process to its end."""
    return _finished(_command(*words), {})


def _command(*words: object) -> list[str]:
    texts = [str(word) for word in words]
    if bpy.app.module:
        return [sys.executable, str(HERE / "command_process.py"), *texts]
    # The preferences, which say that the extension is on, must be on the disk for the new process to find it.
    bpy.ops.wm.save_userpref()
    return [bpy.app.binary_path, "--command", "isochor", *texts]


def _python(place: Path) -> list[str]:
    if bpy.app.module:
        return [sys.executable, str(place)]
    return [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python", str(place)]


def _finished(command: list[str], changes: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, text=True, capture_output=True, timeout=LIMIT_S, env=_env(changes), check=False)


def _env(changes: dict[str, str]) -> dict[str, str]:
    return {**os.environ, **changes}
