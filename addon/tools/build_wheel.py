# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheel `isochor` for release into .build/wheels/, again only when a source of it changed.

Use: python build_wheel.py; prints the wheel's path.
"""

import platform
import shutil
from pathlib import Path

import environments
import toolchain
from workspace import BUILD, ROOT, Command, alone, as_program, fingerprint, is_fresh, output, run, say

PLACE = BUILD / "wheels"
SOURCES = [
    ROOT / name for name in ("native", "shaders", "Cargo.toml", "Cargo.lock", "pyproject.toml", "README.md", "LICENSE")
]
# The oldest glibc that the Blender versions we support run on; PyPI's and Blender's reviewers know the tag.
PORTABLE = "manylinux_2_28"


@alone("wheel")
def wheel() -> Path:
    """The wheel of the sources as they are now, built first if need be."""
    toolchain.cargo()
    python = environments.python("tools")
    stamp = PLACE / "sources.stamp"
    digest = fingerprint([source for source in SOURCES if source.exists()], platform.machine())
    built = sorted(PLACE.glob("*.whl"))
    if is_fresh(stamp, digest) and len(built) == 1:
        return built[0]
    shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True)
    say("building the wheel for release (minutes the first time)")
    _build(python)
    stamp.write_text(digest)
    return next(PLACE.glob("*.whl"))


def _build(python: Path) -> None:
    command: Command = [python, "-m", "maturin", "build", "--release", "--locked", "--out", PLACE]
    env = environments.first_on_path(python)  # where maturin looks for the interpreter and for `-m ziglang`
    if platform.system() != "Linux":
        run(command, env)
        return
    if output([python, "-m", "ziglang", "version"]) is None:
        say(f"zig cannot be had: the wheel is for this machine's glibc and newer only, not {PORTABLE}")
        run([*command, "--compatibility", "linux"], env)
        return
    run([*command, "--zig", "--compatibility", PORTABLE], env)


if __name__ == "__main__":
    as_program(lambda: print(wheel()))
