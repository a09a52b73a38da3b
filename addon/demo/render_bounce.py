# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures and renders the bouncing ball, plain and corrected, in an isolated Blender (run by bouncing_ball.py)."""

import argparse
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

sys.path.insert(0, str(Path(__file__).resolve().parent))

from blender_session import DemoError, command_arguments, enable_cycles, install_extension, run_and_leave
from bounce_table import BounceRow, make_row, write_table

BALL = "Ball"
VARIANTS = ("plain", "isochor")


@contextmanager
def quiet_blender(log_path: Path) -> Iterator[TextIO]:
    """Sends what Blender itself prints to a log file; yields a stream that still reaches the reader."""
    sys.stdout.flush()
    reader = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
    with open(log_path, "ab") as log:
        os.dup2(log.fileno(), 1)
    try:
        yield reader
    finally:
        sys.stdout.flush()
        os.dup2(reader.fileno(), 1)


def show_variant(ball: Any, variant: str) -> None:
    """Turns on Blender's own lattice for "plain" and the extension's modifier for "isochor", and the other one off."""
    from volume_lattice import find_volume_lattice

    ours = find_volume_lattice(ball)
    for modifier in ball.modifiers:
        if modifier.type == "LATTICE" or modifier == ours:
            modifier.show_viewport = modifier.show_render = (modifier == ours) == (variant == "isochor")


def add_plain_lattice(ball: Any) -> None:
    """Adds Blender's own Lattice modifier, on the lattice object of the extension's modifier."""
    from volume_lattice import find_volume_lattice, get_input

    plain = ball.modifiers.new("Plain Lattice", "LATTICE")
    plain.object = get_input(find_volume_lattice(ball), "Lattice")


def marked_losses(scene: Any) -> dict[int, float]:
    """Frame -> share of the volume that the plain lattice should lose, from timeline markers such as "28 %"."""
    return {marker.frame: float(marker.name.rstrip(" %")) / 100 for marker in scene.timeline_markers}


def measure_bounce(scene: Any, ball: Any) -> list[BounceRow]:
    """BounceRows of every frame, both variants measured as a render engine sees them."""
    from measuring_engine import measure_animation
    from surface_measures import enclosed_volume, mesh_arrays

    rest_volume = enclosed_volume(*mesh_arrays(ball.data)) * abs(ball.matrix_world.determinant())
    measured = {}
    for variant in VARIANTS:
        show_variant(ball, variant)
        measured[variant] = measure_animation(scene, ball)
    losses = marked_losses(scene)
    frames = range(scene.frame_start, scene.frame_end + 1)
    return [make_row(f, losses.get(f), rest_volume, *(measured[variant][f] for variant in VARIANTS)) for f in frames]


def render_variant(scene: Any, ball: Any, variant: str, folder: Path, reader: TextIO) -> None:
    """Renders the animation to `folder`/0001.png and on, telling `reader` how far it is."""
    import bpy

    show_variant(ball, variant)
    frames = scene.frame_end - scene.frame_start + 1
    started, done = time.monotonic(), []

    def report(*_: Any) -> None:
        done.append(scene.frame_current)
        spent = time.monotonic() - started
        reader.write(f"  {variant:8} frame {len(done):3d} of {frames}, {spent:5.1f} s\n")

    bpy.app.handlers.render_write.append(report)
    try:
        scene.render.filepath = str(folder) + os.sep
        bpy.ops.render.render(animation=True, scene=scene.name)
    finally:
        bpy.app.handlers.render_write.remove(report)
    if len(done) != frames:
        raise DemoError(f"Blender rendered {len(done)} of {frames} frames of {variant!r}; see render.log.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("--zip", "--fixture", "--out"):
        parser.add_argument(name, type=Path, required=True)
    chosen = parser.parse_args(command_arguments())
    import bpy

    with quiet_blender(chosen.out / "render.log") as reader:
        reader.write(f"Blender {bpy.app.version_string}: installing {chosen.zip.name}\n")
        install_extension(chosen.zip)
        enable_cycles()
        bpy.ops.wm.open_mainfile(filepath=str(chosen.fixture))
        scene, ball = bpy.context.scene, bpy.data.objects[BALL]
        add_plain_lattice(ball)
        reader.write("measuring the ball as a render engine sees it, at every frame\n")
        write_table(chosen.out / "volume.csv", measure_bounce(scene, ball))
        for variant in VARIANTS:
            render_variant(scene, ball, variant, chosen.out / variant, reader)


if __name__ == "__main__":
    run_and_leave(main)
