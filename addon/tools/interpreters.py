# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the Python interpreters of this machine by version, whoever installed them."""

import os
import re
import shutil
import sys
from pathlib import Path

from workspace import output

OLDEST = (3, 11)
PROBE = "import sys; print('%d.%d' % sys.version_info[:2])"


def find(version: str) -> Path | None:
    """An interpreter of that version ("3.13") that really runs, or None."""
    for path in _places(version):
        if output([path, "-c", PROBE]) == version:
            return path
    return None


def any_supported() -> Path:
    """The oldest supported interpreter found: the running one answers where no older one does."""
    versions = (f"3.{minor}" for minor in range(OLDEST[1], sys.version_info.minor))
    older = (find(version) for version in versions)
    return next((path for path in older if path is not None), Path(sys.executable))


def _places(version: str) -> list[Path]:
    """Where an interpreter of that version may be: this one, PATH, pyenv's and uv's folders."""
    places = [Path(sys.executable)]
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        places += [Path(folder, f"python{version}"), Path(folder, "python3")]
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    places += sorted((pyenv / "versions").glob(f"{version}.*/bin/python3"), key=_patch, reverse=True)
    uv = shutil.which("uv")
    found = output([uv, "python", "find", version]) if uv else None
    return [path for path in places + ([Path(found)] if found else []) if path.is_file()]


def _patch(path: Path) -> int:
    numbers = re.findall(r"\d+", path.parents[1].name)
    return int(numbers[2]) if len(numbers) > 2 else 0
