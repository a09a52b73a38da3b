# SPDX-License-Identifier: GPL-3.0-or-later
"""A file with a baked or applied result renders the same pictures in a Blender without the add-on."""

from pathlib import Path

import bpy
import elsewhere
import numpy as np
import pytest
import scenes

FRAMES = (2, 4)


def bouncing() -> bpy.types.Object:
    """The ball in an animated lattice, a camera and a light."""
    ball = scenes.sphere(32, 20)
    lattice = scenes.squashing_lattice(ball, 6, frames=6)
    scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (np.pi / 2, 0.0, 0.0)
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "SUN"))
    light.rotation_euler = (0.6, 0.3, 0.0)
    light.data.energy = 3.0
    for obj in (camera, light):
        bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = camera
    scenes.choose(ball)
    return ball


def set_up(first: int, last: int) -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = 4, False, 1
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.frame_start, scene.frame_end, scene.frame_step = first, last, max(1, last - first)


def pictures(folder: Path) -> list[np.ndarray]:
    found = []
    for file in sorted(folder.glob("*.exr")):
        image = bpy.data.images.load(str(file))
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        found.append(pixels)
        bpy.data.images.remove(image)
    return found


def rendered_here(folder: Path) -> list[np.ndarray]:
    bpy.context.scene.render.filepath = f"{folder}/"
    bpy.ops.render.render(animation=True)
    return pictures(folder)


def require_same(with_add_on: list[np.ndarray], without: list[np.ndarray]) -> None:
    assert len(with_add_on) == len(without) > 0
    for one, other in zip(with_add_on, without, strict=True):
        assert one.std() > 0.05
        assert np.mean(np.abs(one - other) > 1e-3) < 1e-3


@pytest.mark.parametrize("kind", ["PC2", "MDD", "SHAPE_KEYS", "LATTICE"])
def test_a_baked_file_renders_the_same_without_the_add_on(tmp_path, kind):
    bouncing()
    set_up(*FRAMES)
    wanted = rendered_here(tmp_path / "with")
    assert np.mean(np.abs(wanted[0] - wanted[1]) > 1e-3) > 0.01, "the frames must differ, or nothing is compared"
    assert bpy.ops.isochor.bake(format=kind, frame_start=1, frame_end=6, directory=str(tmp_path)) == {"FINISHED"}
    bpy.context.scene.frame_set(1)
    require_same(wanted, pictures(elsewhere.rendered(tmp_path)))


@pytest.mark.parametrize("as_shape_key", [False, True])
def test_an_applied_shape_renders_the_same_without_the_add_on(tmp_path, as_shape_key):
    bouncing()
    set_up(4, 4)
    wanted = rendered_here(tmp_path / "with")
    bpy.context.scene.frame_set(4)
    assert bpy.ops.isochor.apply(as_shape_key=as_shape_key) == {"FINISHED"}
    require_same(wanted, pictures(elsewhere.rendered(tmp_path)))
