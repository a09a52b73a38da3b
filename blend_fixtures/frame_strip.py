# SPDX-License-Identifier: GPL-3.0-or-later
"""Several frames of a scene side by side in one picture (bpy)."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy


def render_strip(frames: Sequence[int], output: Path) -> None:
    """Renders these frames of the open scene, as large as it says, next to each other into a picture."""
    from PIL import Image

    scene = bpy.context.scene
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for frame in frames:
            scene.frame_set(frame)
            scene.render.filepath = f"{folder}/{frame:04d}.png"
            bpy.ops.render.render(write_still=True, scene=scene.name)
            pictures.append(Image.open(scene.render.filepath).convert("RGB"))
    strip = Image.new("RGB", (sum(picture.width for picture in pictures), pictures[0].height))
    for number, picture in enumerate(pictures):
        strip.paste(picture, (number * picture.width, 0))
    strip.save(output)
