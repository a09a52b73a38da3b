# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing ball on the GPU renders the frames that it renders on the CPU."""

from pathlib import Path

import bpy
import isochor
import numpy as np
import pytest
import scenes
from installed_extension import MODULE
from numpy.typing import NDArray

FIXTURE = Path(__file__).resolve().parents[2] / "blend_fixtures" / "bouncing_ball.blend"
MARKED = (16, 19, 24)  # where the plain lattice loses 28, 51 and 64 %
HAS_GPU = any(device.kind != "cpu" for device in isochor.devices())
PIXEL = 2.0 / 255.0  # largest difference of a channel of a pixel: float32 corrections move an edge by 1e-5 of a pixel
APART = 1e-5  # largest difference of a vertex, in units of the ball of radius 1


@pytest.fixture
def ball():
    bpy.ops.wm.open_mainfile(filepath=str(FIXTURE))
    yield bpy.data.objects["Ball"]
    bpy.context.preferences.addons[MODULE].preferences.device = "AUTO"


def on(device: str, ball: bpy.types.Object, frame: int) -> NDArray[np.float64]:
    """The vertices of a frame, computed on this device."""
    bpy.context.preferences.addons[MODULE].preferences.device = device
    bpy.context.scene.frame_set(frame)
    modifier = ball.modifiers[scenes.MODIFIER]
    expected = "gpu" if device == "GPU" and HAS_GPU else "cpu"
    assert scenes.report(ball, modifier).device == expected
    return scenes.evaluated_positions(ball)


def picture(path: Path, frame: int) -> NDArray[np.float32]:
    """The frame as rendered, in small: (H, W, 4) in [0, 1]."""
    scene = bpy.context.scene
    scene.render.resolution_percentage = 25
    scene.render.filepath = str(path)
    scene.frame_set(frame)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    shape = (image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return pixels.reshape(shape)


@pytest.mark.filterwarnings("ignore:GPU:RuntimeWarning")
def test_every_frame_has_the_cpu_s_vertices_and_volume(ball):
    frames = range(bpy.context.scene.frame_start, bpy.context.scene.frame_end + 1)
    expected = {frame: on("CPU", ball, frame) for frame in frames}
    whole = scenes.volume(ball.data)
    for frame in frames:
        assert np.abs(on("GPU", ball, frame) - expected[frame]).max() < APART
        assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6


@pytest.mark.filterwarnings("ignore:GPU:RuntimeWarning")
def test_marked_frames_are_rendered_alike(ball, tmp_path):
    preferences = bpy.context.preferences.addons[MODULE].preferences
    for frame in MARKED:
        pictures = []
        for device in ("CPU", "GPU"):
            preferences.device = device
            pictures.append(picture(tmp_path / f"{device}{frame}.png", frame))
            rendered = scenes.report(ball, ball.modifiers[scenes.MODIFIER], "RENDER").device
            assert rendered == ("gpu" if device == "GPU" and HAS_GPU else "cpu")
        assert pictures[0].std() > 0.01, "there is something to see"
        difference = np.abs(pictures[0] - pictures[1]).max()
        print(f"frame {frame}: pixels differ by at most {difference:.4f}")
        assert difference <= PIXEL
