# SPDX-License-Identifier: GPL-3.0-or-later
"""What is rendered: the right frame, sub-frames for motion blur included, in this process and from the command line."""

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import pytest
import scenes
from installed_extension import ISOLATION, MODULE

FRAMES = (3, 8, 13)


class MeasuringEngine(bpy.types.RenderEngine):
    """Instead of a picture it notes the volume and shape of what a render engine gets, on the frame and between."""

    bl_idname = "ISOCHOR_MEASURING"
    bl_label = "Measuring"
    noted: list[tuple[float, int, float, np.ndarray]] = []

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        frame = depsgraph.scene.frame_current
        for subframe in (0.0, 0.25, 0.75):
            self.frame_set(frame, subframe=subframe)
            mesh = depsgraph.id_eval_get(bpy.data.objects["Ball"]).data
            self.noted.append((frame + subframe, len(mesh.vertices), scenes.volume(mesh), scenes.positions(mesh)))


@pytest.fixture
def noted():
    """What the measuring engine saw."""
    bpy.utils.register_class(MeasuringEngine)
    MeasuringEngine.noted.clear()
    yield MeasuringEngine.noted
    bpy.utils.unregister_class(MeasuringEngine)


def moving_scene(native: bool, preserve: float = 0.0) -> bpy.types.Object:
    """The ball in an animated uniform cubic lattice, which Blender's own modifier and ours evaluate alike."""
    ball = scenes.sphere(32, 20)
    lattice = scenes.squashing_lattice(ball, 6, frames=16)
    bpy.context.scene.frame_set(1)
    if native:
        scenes.native_lattice(ball, lattice)
    else:
        scenes.volume_lattice(ball, lattice, Basis="B-Spline", Preserve=preserve)
    add_camera_and_light()
    return ball


def add_camera_and_light() -> None:
    """From the front, a little from above."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (np.pi / 2, 0.0, 0.0)
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "SUN"))
    light.rotation_euler = (0.6, 0.3, 0.0)
    light.data.energy = 3.0
    for obj in (camera, light):
        bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = camera


def set_up_render(folder: Path, motion_blur: bool) -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = 8, False, 1
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.render.use_motion_blur = motion_blur
    scene.render.motion_blur_shutter = 1.0
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(folder / "frame_")
    scene.frame_start, scene.frame_end, scene.frame_step = FRAMES[0], FRAMES[-1], FRAMES[1] - FRAMES[0]


def pictures(folder: Path) -> np.ndarray:
    """(frames, pixels, 4), linear."""
    found = []
    for frame in FRAMES:
        image = bpy.data.images.load(str(folder / f"frame_{frame:04d}.exr"))
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        found.append(pixels.reshape(-1, 4))
        bpy.data.images.remove(image)
    return np.stack(found)


def agree(ours: np.ndarray, native: np.ndarray) -> bool:
    """Whether the pictures show the same; a ray that grazes an edge may fall on either side of it."""
    return np.mean(np.abs(ours - native) > 1e-3) < 1e-3


@pytest.mark.parametrize("motion_blur", [False, True])
def test_rendered_animation_is_that_of_blender_s_own_modifier(tmp_path, motion_blur):
    found = []
    for native in (True, False):
        scenes.empty_file()
        moving_scene(native)
        folder = tmp_path / ("native" if native else "ours")
        set_up_render(folder, motion_blur)
        bpy.ops.render.render(animation=True)
        found.append(pictures(folder))
    native, ours = found
    assert not agree(native[0], native[1]), "the frames must differ, or the comparison could not fail"
    assert agree(ours, native)


@pytest.mark.parametrize("motion_blur", [False, True])
def test_rendered_from_the_command_line(tmp_path, motion_blur):
    found = []
    for native in (True, False):
        scenes.empty_file()
        moving_scene(native)
        folder = tmp_path / ("native" if native else "ours")
        set_up_render(folder, motion_blur)
        place = tmp_path / f"{folder.name}.blend"
        bpy.context.scene.frame_set(1)
        bpy.ops.wm.save_as_mainfile(filepath=str(place))
        render_in_a_new_process(place)
        found.append(pictures(folder))
    native, ours = found
    assert not agree(native[0], native[1]), "the frames must differ, or the comparison could not fail"
    assert agree(ours, native)


def render_in_a_new_process(place: Path) -> None:
    """blender -b FILE -a; the bpy wheel has no such program, there a script loads the file and renders it."""
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "--addons", MODULE, str(place), "-a"]
    else:
        script = (
            "import os, sys, bpy, addon_utils; addon_utils.enable(sys.argv[1]);"
            "bpy.ops.wm.open_mainfile(filepath=sys.argv[2]); bpy.ops.render.render(animation=True);"
            "sys.stdout.flush(); os._exit(0)"
        )
        command = [sys.executable, "-c", script, MODULE, str(place)]
    assert ISOLATION in os.environ
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_volume_of_what_is_rendered_on_frames_and_between(noted):
    ball = moving_scene(native=False, preserve=1.0)
    whole = scenes.volume(ball.data)
    scene = bpy.context.scene
    scene.render.engine = MeasuringEngine.bl_idname
    scene.frame_start, scene.frame_end, scene.frame_step = 3, 13, 5
    bpy.ops.render.render(animation=True)
    assert [when for when, *_ in noted] == [f + s for f in FRAMES for s in (0.0, 0.25, 0.75)]
    shapes = [shape for *_, shape in noted]
    for _, _, volume, _ in noted:
        assert abs(volume / whole - 1) <= 1e-6
    for one, next_one in pairwise(shapes):
        assert np.abs(one - next_one).max() > 1e-3
    for when, _, _, shape in noted:
        scene.frame_set(int(when), subframe=when - int(when))
        assert np.abs(scenes.evaluated_positions(ball) - shape).max() < 2e-6


def test_single_picture_after_an_edit_shows_the_edit(noted):
    ball = moving_scene(native=False, preserve=1.0)
    scene = bpy.context.scene
    scene.render.engine = MeasuringEngine.bl_idname
    scene.frame_set(8)
    modifier = ball.modifiers[0]
    scenes.set_input(modifier, "Target", 1.2)
    bpy.ops.render.render()
    when, _, volume, _ = noted[0]
    assert when == 8.0
    assert abs(volume / (1.2 * scenes.volume(ball.data)) - 1) <= 1e-6


def test_viewport_and_render_have_levels_and_results_of_their_own(noted):
    add_camera_and_light()
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.name = "Ball"
    subdivision = cube.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 3
    cube.modifiers.new("Triangulate", "TRIANGULATE")
    lattice = scenes.squashing_lattice(cube, 6, frames=16)
    bpy.context.scene.frame_set(1)
    modifier = scenes.volume_lattice(cube, lattice, Basis="B-Spline")
    in_viewport = scenes.evaluated_volume(cube)
    rest = scenes.get_input(modifier, "Render Result")["isochor_rest_volume"]
    scene = bpy.context.scene
    scene.render.engine = MeasuringEngine.bl_idname
    scene.frame_start = scene.frame_end = 8
    bpy.ops.render.render(animation=True)
    counts = {count for _, count, *_ in noted}
    assert counts == {len(scenes.get_input(modifier, "Render Result").data.vertices)}
    assert counts != {len(scenes.evaluated_mesh(cube).vertices)}
    for _, _, volume, _ in noted:
        assert abs(volume / rest - 1) <= 1e-6
    scene.frame_set(8)
    assert abs(scenes.evaluated_volume(cube) / in_viewport - 1) <= 1e-6
    assert abs(rest / in_viewport - 1) > 1e-3


def test_render_takes_the_rest_volume_of_the_viewport_where_it_keeps_none(noted):
    ball = moving_scene(native=False, preserve=1.0)
    shown, rendered = (scenes.get_input(ball.modifiers[0], f"{mode} Result") for mode in ("Viewport", "Render"))
    wanted = 1.1 * scenes.volume(ball.data)
    shown["isochor_rest_volume"] = wanted
    del rendered["isochor_rest_volume"]
    bpy.context.scene.render.engine = MeasuringEngine.bl_idname
    bpy.context.scene.frame_set(8)
    bpy.ops.render.render()
    assert rendered["isochor_rest_volume"] == wanted
    for _, _, volume, _ in noted:
        assert abs(volume / wanted - 1) <= 1e-6


def test_problem_does_not_stop_a_render(noted, capfd):
    ball = moving_scene(native=False, preserve=1.0)
    bpy.data.objects.remove(scenes.get_input(ball.modifiers[0], "Lattice"))
    scene = bpy.context.scene
    scene.render.engine = MeasuringEngine.bl_idname
    scene.frame_start, scene.frame_end = 1, 4
    bpy.ops.render.render(animation=True)
    assert len(noted) == 12
    for *_, shape in noted:
        assert np.array_equal(shape, scenes.positions(ball.data))
    assert capfd.readouterr().out.count("Isochor: Ball: No lattice") == 1
