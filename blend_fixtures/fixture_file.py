# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing the committed .blend files (bpy)."""

import argparse
from collections.abc import Callable
from pathlib import Path

import bpy
from blender_session import command_arguments


def save(output: Path) -> None:
    """Writes what is open, compressed, and says how large it came out."""
    bpy.ops.wm.save_as_mainfile(filepath=str(output.resolve()), compress=True, copy=True)
    print(f"{output}: {output.stat().st_size / 1e6:.2f} MB, Blender {bpy.app.version_string}")


def make(make_scene: Callable[[], object], default: Path, description: str) -> None:
    """Makes the scene in an empty file, and writes it to the default place or to that of --output."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--output", type=Path, default=default)
    chosen = parser.parse_args(command_arguments())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make_scene()
    save(chosen.output)
