# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the installable zip dist/isochor-<version>-<platform>.zip from addon/isochor and the release wheel.

Use: python build_extension.py; prints the zip's path.
"""

import platform
import shutil
import tomllib
import zipfile
from pathlib import Path

import blenders
import build_wheel
import toolchain
from workspace import BUILD, DIST, ROOT, Unavailable, alone, as_program, fingerprint, is_fresh, run, say

SOURCE = ROOT / "addon" / "isochor"
MANIFEST = "blender_manifest.toml"
# These keys of the manifest are the build's to write; the source has none of them.
WRITTEN = ("version", "platforms", "wheels")
SYSTEMS = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}
MACHINES = {"x86_64": "x64", "AMD64": "x64", "aarch64": "arm64", "arm64": "arm64"}
# Zip files cannot say "no date"; with this one, equal contents are equal files.
DATE = (1980, 1, 1, 0, 0, 0)


@alone("extension")
def extension() -> Path:
    """The zip of the sources as they are now, built and validated first if need be."""
    wheel = build_wheel.wheel()
    version = toolchain.workspace_package()["version"]
    place = DIST / f"isochor-{version}-{platform_name()}.zip"
    stamp = BUILD / "extension.stamp"
    digest = fingerprint([SOURCE, wheel, Path(__file__)], version)
    if is_fresh(stamp, digest) and place.is_file():
        return place
    say(f"building {place.relative_to(ROOT)}")
    staging = _staged(wheel, version)
    DIST.mkdir(exist_ok=True)
    _pack(staging, place)
    validate(place)
    stamp.write_text(digest)
    return place


def platform_name() -> str:
    """This machine as Blender's extension manifests name it, for example linux-x64."""
    system, machine = platform.system(), platform.machine()
    if system not in SYSTEMS or machine not in MACHINES:
        raise Unavailable(f"Blender has no name for a {machine} under {system}: no extension can be built here")
    return f"{SYSTEMS[system]}-{MACHINES[machine]}"


def manifest(source: str, version: str, wheel: str) -> str:
    """The manifest of the zip: the source's with version, platform and wheel written before its first table."""
    present = [key for key in WRITTEN if key in tomllib.loads(source)]
    if present:
        raise Unavailable(f"{SOURCE / MANIFEST} sets {', '.join(present)}, which the build writes: remove them there")
    written = f'version = "{version}"\nplatforms = ["{platform_name()}"]\nwheels = ["./wheels/{wheel}"]\n'
    lines = source.splitlines(keepends=True)
    first_table = next((index for index, line in enumerate(lines) if line.startswith("[")), len(lines))
    return "".join([*lines[:first_table], written, "\n", *lines[first_table:]])


def validate(place: Path) -> None:
    """Has Blender's own tool check the zip, in a Blender that is there already."""
    blender = blenders.already_there()
    if blender is None:
        say("not validated: no Blender is set up here yet (`make demo` and `make test` set one up)")
        return
    run([*blender.extension_tool(), "validate", place], blender.isolation("validate"))


def _staged(wheel: Path, version: str) -> Path:
    staging = BUILD / "extension"
    shutil.rmtree(staging, ignore_errors=True)
    shutil.copytree(SOURCE, staging, ignore=shutil.ignore_patterns("__pycache__", "*.pyc", "wheels"))
    (staging / "wheels").mkdir()
    shutil.copyfile(wheel, staging / "wheels" / wheel.name)
    text = manifest((SOURCE / MANIFEST).read_text(encoding="utf-8"), version, wheel.name)
    (staging / MANIFEST).write_text(text, encoding="utf-8")
    shutil.copyfile(ROOT / "LICENSE", staging / "LICENSE")
    return staging


def _pack(folder: Path, place: Path) -> None:
    place.unlink(missing_ok=True)
    with zipfile.ZipFile(place, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            entry = zipfile.ZipInfo(str(file.relative_to(folder)), DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    as_program(lambda: print(extension()))
