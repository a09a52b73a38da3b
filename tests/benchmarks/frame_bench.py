# SPDX-License-Identifier: GPL-3.0-or-later
"""Times scene.frame_set in Blender: Blender's own Lattice modifier against Volume Lattice with the volume kept.

Same mesh and the same animated lattice of 10 x 10 x 10 points for all, uniform cubic B-splines, medians of one run.
Use: python frame_bench.py --zip dist/isochor-….zip, or in blender -b … --python frame_bench.py -- --zip ….zip
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender"))

import installed_extension

installed_extension.isolate()

import bpy  # noqa: E402
import scenes  # noqa: E402

TO_REACH = 0.7
SIDE = 10
FRAMES = 40
"""Enough for a median that two runs agree on to a few per cent."""
WARM_UP = 5
"""Frames not counted: the first ones embed, and find the memory that later ones use again."""
SIZES = {"35 thousand": (188, 186), "440 thousand": (664, 664)}
"""Columns and rows of the sphere."""


def main() -> int:
    parser = argparse.ArgumentParser(description="Times frame changes in Blender.")
    parser.add_argument("--zip", type=Path, required=True, help="the extension that make extension built")
    installed_extension.install(parser.parse_args(installed_extension.own_arguments()).zip)
    print(f"Blender {bpy.app.version_string}: milliseconds of scene.frame_set, median of {FRAMES} frames")
    print(f"{'vertices':>10}  {'modifier':34}{'ms':>9}  {'÷ Blender':>9}")
    for columns, rows in SIZES.values():
        measure_size(columns, rows)
    return 0


def measure_size(columns: int, rows: int) -> None:
    """Prints one block of the table."""
    scenes.empty_file()
    ball = scenes.sphere(columns, rows)
    lattice = scenes.squashing_lattice(ball, SIDE, frames=FRAMES + WARM_UP)
    native = timed(lambda: scenes.native_lattice(ball, lattice))
    print_row(ball, "Blender's Lattice", native, None)
    for preserve, method in ((0.0, "Balanced"), (1.0, "Balanced"), (1.0, "Sweep")):
        label = f"Volume Lattice, {method}" if preserve else "Volume Lattice, Preserve 0"
        values = {"Basis": "B-Spline", "Preserve": preserve, "Method": method}
        ours = timed(lambda values=values: scenes.volume_lattice(ball, lattice, **values))
        goal = f"  (to reach: {TO_REACH})" if preserve and len(ball.data.vertices) > 400_000 else ""
        print_row(ball, label, ours, native, goal)


def timed(add_modifier: Callable[[], bpy.types.Modifier]) -> float:
    """Median milliseconds of a frame change with the modifier; takes it away again."""
    modifier = add_modifier()
    scene = bpy.context.scene
    times = []
    for frame in range(1, FRAMES + WARM_UP + 1):
        started = perf_counter()
        scene.frame_set(frame)
        times.append((perf_counter() - started) * 1e3)
    modifier.id_data.modifiers.remove(modifier)
    return median(times[WARM_UP:])


def print_row(ball: bpy.types.Object, label: str, found: float, native: float | None, goal: str = "") -> None:
    ratio = f"{found / native:9.2f}" if native else ""
    print(f"{len(ball.data.vertices):>10}  {label:34}{found:9.2f}  {ratio}{goal}", flush=True)


if __name__ == "__main__":
    installed_extension.leave(main())
