# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blenders that the tools can run a script in: the bpy wheels, a real `blender`, the Debian tree of blender_root.

All run it in the background, from factory settings, with a user folder of their own.
"""

import os
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import blender_root
import environments
import interpreters
import system_packages
from workspace import BUILD, Unavailable, output, say

OLDEST = (4, 5)
# Newest first: the bpy wheel that each environment holds.
WHEELS = ("3.13", "3.11")
FACTORY = ("--background", "--factory-startup", "--python-exit-code", "1", "--python")


@dataclass(frozen=True)
class Blender:
    """A Blender that is there: how it is called and what it calls itself."""

    name: str
    program: Path
    is_wheel: bool
    has_pictures: bool  # its Python has Pillow and matplotlib

    def command(self, script: Path, *arguments: str | Path) -> list[str]:
        """The command that runs the script in it; the script reads the arguments behind "--" or as its own."""
        words = [str(argument) for argument in arguments]
        if self.is_wheel:
            return [str(self.program), str(script), *words]
        return [str(self.program), *FACTORY, str(script), "--", *words]

    def isolation(self, purpose: str) -> dict[str, str]:
        """The environment that keeps it away from the user's own Blender settings; the folder is made empty."""
        folder = BUILD / "blender-user" / f"{purpose}-{self.name.replace(' ', '-')}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return {"BLENDER_USER_RESOURCES": str(folder), "PYTHONNOUSERSITE": "1"}

    def extension_tool(self) -> list[str]:
        """The command to which Blender's own `validate` for extensions is given."""
        if not self.is_wheel:
            return [str(self.program), "--command", "extension"]
        inside = next(self.program.parents[1].glob("lib*/python*/site-packages/bpy/*/scripts/addons_core/bl_pkg"))
        return [str(self.program), str(inside / "cli" / "blender_ext.py")]


def wheel(version: str) -> Blender:
    """The bpy wheel in the environment of that Python version, made first if need be."""
    python = environments.python(version)
    bpy = next(package for package in environments.ENVIRONMENTS[version].packages if package.startswith("bpy"))
    return Blender(bpy.replace("==", " "), python, is_wheel=True, has_pictures=True)


def real(program: Path, has_pictures: bool = False) -> Blender:
    """A real Blender; raises Unavailable where it does not run or is too old."""
    version = re.search(r"Blender (\d+)\.(\d+)(\.\d+)?", output([program, "--version"]) or "")
    if version is None:
        raise Unavailable(f"{program} does not answer to --version as Blender does")
    if (int(version[1]), int(version[2])) < OLDEST:
        raise Unavailable(f"{program} is {version[0]}, Blender {OLDEST[0]}.{OLDEST[1]} or newer is needed")
    return Blender(version[0].lower(), program, is_wheel=False, has_pictures=has_pictures)


def in_root() -> Blender:
    """The real Blender of the Debian tree, made first if need be."""
    return real(blender_root.launcher(), has_pictures=True)


def preferred() -> Blender:
    """The Blender for the demo: BLENDER, `blender` on PATH, a bpy wheel, or what can be fetched; else Unavailable."""
    named = os.environ.get("BLENDER")
    if named:
        return _named(named)
    on_path = shutil.which("blender")
    attempts: list[Callable[[], Blender]] = [partial(real, Path(on_path))] if on_path else []
    fitting = [version for version in WHEELS if interpreters.find(version)]
    attempts += [partial(wheel, version) for version in fitting] or [_with_fetched_python]
    return _first([*attempts, in_root])


def already_there() -> Blender | None:
    """A Blender that needs no setting-up, or None."""
    for version in WHEELS:
        if (environments.folder(version) / "contents.stamp").is_file():
            return wheel(version)
    program = os.environ.get("BLENDER") or shutil.which("blender")
    try:
        return real(Path(program)) if program else None
    except Unavailable as reason:
        say(str(reason))
        return None


def _named(program: str) -> Blender:
    try:
        return real(Path(shutil.which(program) or program))
    except Unavailable as reason:
        raise Unavailable(f"the environment variable BLENDER is of no use here: {reason}") from reason


def _first(attempts: list[Callable[[], Blender]]) -> Blender:
    for attempt in attempts:
        try:
            return attempt()
        except Unavailable as reason:
            say(f"{reason}; looking further")
    raise Unavailable("no Blender can be had here: name one (4.5 or newer) in the environment variable BLENDER")


def _with_fetched_python() -> Blender:
    """A bpy wheel in Python 3.13 or 3.11 from the system's packages or through uv."""
    say(f"no Python {' or '.join(WHEELS)} here, which the bpy wheels need, and no `blender` on PATH: looking for one")
    for version in WHEELS:
        if system_packages.candidate(f"python{version}"):
            system_packages.install([f"python{version}", f"python{version}-venv"])
            return wheel(version)
    uv = shutil.which("uv")
    if uv is None or output([uv, "python", "install", WHEELS[0]]) is None:
        raise Unavailable("neither apt-get nor uv has a Python that a bpy wheel fits")
    return wheel(WHEELS[0])
