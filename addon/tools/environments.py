# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the Python environments of the build under .build/, each once and again only when its description changes.

Use: python environments.py NAME... with names from ENVIRONMENTS; prints the folder of each.
"""

import os
import sys
from dataclasses import dataclass
from pathlib import Path

import interpreters
import system_packages
from workspace import BUILD, Unavailable, alone, as_program, fail, fingerprint, is_fresh, output, run, say, status

TESTING = ("pytest==9.0.2", "hypothesis==6.148.2", "scipy")
PICTURES = ("pillow", "matplotlib")
FARMS = ("openjd-cli==0.8.0", "opencue-pyoutline==1.37.0")


@dataclass(frozen=True)
class Environment:
    """One virtual environment: the Python version it needs (None: the oldest supported) and what pip puts in it."""

    python: str | None
    packages: tuple[str, ...]
    system: str | None = None

    def interpreter(self) -> Path | None:
        """An interpreter of this machine that fits, or None."""
        return interpreters.find(self.python) if self.python else interpreters.any_supported()


ENVIRONMENTS = {
    # maturin and ziglang build the wheel; ruff and mypy check the Python code.
    "tools": Environment(None, ("maturin==1.16.0", "ziglang==0.15.2", "ruff==0.17.6", "mypy==2.4.1", "numpy")),
    # The wheel itself is installed here by the tests and benchmarks.
    "native": Environment(None, ("numpy", *TESTING)),
    # CuPy, which fits one version of CUDA, is added by hand: its baseline is measured where it is there.
    "gpu-bench": Environment(None, ("numpy", "scipy", "matplotlib")),
    # A JavaScript engine for the Flamenco job type, the tools of OpenJD and OpenCue, and what compares frames.
    "farm": Environment(None, (TESTING[0], "quickjs==1.19.4", *FARMS, "packaging", "numpy", "pillow")),
    # The wheel is installed here too, to be described.
    "docs": Environment(None, ("pdoc==16.0.0", "numpy")),
    # Draws the demo's pictures where the Blender found brings its own Python without them.
    "pictures": Environment(None, ("numpy", *PICTURES)),
    "3.13": Environment("3.13", ("bpy==5.2.3", *TESTING, *PICTURES), system="bpy"),
    "3.11": Environment("3.11", ("bpy==4.5.15", *TESTING, *PICTURES), system="bpy"),
}


def folder(name: str) -> Path:
    """Where the environment of that name is or will be."""
    return BUILD / f"venv-{name}"


def python(name: str) -> Path:
    """The interpreter of the environment of that name, made and filled first if need be."""
    with alone(f"venv-{name}"):
        return _made(name)


def _made(name: str) -> Path:
    environment = ENVIRONMENTS[name]
    place = folder(name)
    interpreter = place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp = place / "contents.stamp"
    digest = fingerprint([], *environment.packages)
    if is_fresh(stamp, digest) and interpreter.exists():
        return interpreter
    if environment.system:
        system_packages.install(system_packages.GROUPS[environment.system])
    if not interpreter.exists():
        _create(name, place)
    say(f"installing {' '.join(environment.packages)} into {place}")
    if status([interpreter, "-m", "pip", "install", "-q", "--disable-pip-version-check", *environment.packages]) != 0:
        raise Unavailable(f"pip could not install {' '.join(environment.packages)}: see its message above")
    stamp.write_text(digest)
    return interpreter


def first_on_path(interpreter: Path) -> dict[str, str]:
    """The environment variables under which programs find this interpreter as `python` and `python3`."""
    return {"PATH": f"{interpreter.parent}{os.pathsep}{os.environ['PATH']}"}


def install_wheel(name: str, wheel: Path) -> Path:
    """The interpreter of the environment, with exactly this wheel installed in it."""
    interpreter = python(name)
    stamp = folder(name) / "wheel.stamp"
    digest = fingerprint([wheel])
    if not is_fresh(stamp, digest):
        say(f"installing {wheel.name} into {folder(name)}")
        run([interpreter, "-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall", wheel])
        stamp.write_text(digest)
    return interpreter


def _create(name: str, place: Path) -> None:
    environment = ENVIRONMENTS[name]
    found = environment.interpreter()
    if found is None:
        raise Unavailable(f"Python {environment.python} was not found on this machine (needed for {place.name})")
    _ensure_pip(found)
    say(f"creating {place} with {found}")
    run([found, "-m", "venv", "--clear", place])


def _ensure_pip(interpreter: Path) -> None:
    """Debian's interpreters come without ensurepip, which venv needs: its package is python3.X-venv."""
    if output([interpreter, "-c", "import ensurepip"]) is None:
        version = output([interpreter, "-c", interpreters.PROBE])
        system_packages.install([f"python{version}-venv"])


def main(names: list[str]) -> None:
    unknown = [name for name in names if name not in ENVIRONMENTS]
    if unknown or not names:
        fail(f"environments.py: unknown name {' '.join(unknown) or '(none given)'}, expected {' '.join(ENVIRONMENTS)}")
    for name in names:
        python(name)
        print(os.fspath(folder(name)))


if __name__ == "__main__":
    as_program(lambda: main(sys.argv[1:]))
