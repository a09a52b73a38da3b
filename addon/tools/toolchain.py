# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the Rust toolchain, says what to do where there is none, and installs a missing C linker."""

import os
import platform
import re
import shutil
import tomllib
from pathlib import Path

import system_packages
from workspace import ROOT, Unavailable, output

CARGO_HOME = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
ADVICE = "install Rust with rustup (https://rustup.rs), then run this again"


def cargo() -> str:
    """The cargo to call; raises Unavailable where there is none or an older one than the workspace needs."""
    found = shutil.which("cargo") or shutil.which("cargo", path=CARGO_HOME / "bin")
    if found is None:
        raise Unavailable(f"no Rust toolchain (cargo) was found: {ADVICE}")
    os.environ["PATH"] = f"{Path(found).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    needed = workspace_package()["rust-version"]
    version = re.search(r"\d+\.\d+", output([found, "--version"]) or "")
    if version is None or _numbers(version[0]) < _numbers(needed):
        raise Unavailable(f"Rust {needed} or newer is needed, {found} is {version and version[0]}: {ADVICE}")
    if platform.system() == "Linux" and shutil.which("cc") is None:
        system_packages.install(system_packages.GROUPS["compiler"])
    return found


def workspace_package() -> dict[str, str]:
    """The [workspace.package] table of Cargo.toml: the one place where the version stands."""
    with (ROOT / "Cargo.toml").open("rb") as file:
        package: dict[str, str] = tomllib.load(file)["workspace"]["package"]
    return package


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split(".")[:2])
