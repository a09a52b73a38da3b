# SPDX-License-Identifier: GPL-3.0-or-later
"""The preference of a device: the same picture on each, changed mid-session, and the CPU where there is no GPU."""

import os
from collections.abc import Iterator

import bpy
import isochor
import numpy as np
import pytest
import scenes
from installed_extension import MODULE

FRAMES = 12
HAS_GPU = any(device.kind != "cpu" for device in isochor.devices())
APART = 2e-5  # between a float32 and a float64 correction of a ball of radius 1


@pytest.fixture(autouse=True)
def preferences() -> Iterator[bpy.types.AddonPreferences]:
    found = bpy.context.preferences.addons[MODULE].preferences
    yield found
    found.device, found.adapter = "AUTO", ""


def squashed_ball() -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    ball = scenes.sphere()
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    return ball, scenes.volume_lattice(ball, lattice, Basis="B-Spline")


def frames(ball: bpy.types.Object) -> list[np.ndarray]:
    found = []
    for frame in range(1, FRAMES + 1, 3):
        bpy.context.scene.frame_set(frame)
        found.append(scenes.evaluated_positions(ball))
    return found


def used(ball: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    return scenes.report(ball, modifier).device


def test_there_is_an_adapter_where_one_was_promised():
    assert HAS_GPU or "ISOCHOR_GPU_EXPECTED" not in os.environ, "the tests of the GPU in Blender would test the CPU"


def test_auto_is_the_default_and_small_meshes_stay_on_the_cpu(preferences):
    ball, modifier = squashed_ball()
    frames(ball)
    assert preferences.device == "AUTO"
    assert used(ball, modifier) == "cpu"


@pytest.mark.filterwarnings("ignore:GPU:RuntimeWarning")
def test_the_device_changes_mid_session_and_the_picture_does_not(preferences):
    ball, modifier = squashed_ball()
    whole = scenes.volume(ball.data)
    preferences.device = "CPU"
    expected = frames(ball)
    assert used(ball, modifier) == "cpu"
    for device, runs_on in (("GPU", "gpu" if HAS_GPU else "cpu"), ("CPU", "cpu"), ("GPU", "gpu" if HAS_GPU else "cpu")):
        preferences.device = device
        for found, wanted in zip(frames(ball), expected):
            assert np.abs(found - wanted).max() < APART
            assert abs(scenes.evaluated_volume(ball) / whole - 1) <= 1e-6
        assert used(ball, modifier) == runs_on
        name = scenes.report(ball, modifier).device_name
        assert dict(scenes.part("ui.sidebar").rows(scenes.report(ball, modifier)))["Computed on"] == name
        assert (name == "cpu") == (runs_on == "cpu")


def test_a_change_of_device_alone_computes_anew(preferences):
    ball, modifier = squashed_ball()
    bpy.context.scene.frame_set(6)
    before = scenes.evaluated_positions(ball)
    assert used(ball, modifier) == "cpu"
    if not HAS_GPU:
        preferences.device = "CPU"
    else:
        preferences.device = "GPU"
    bpy.context.view_layer.update()
    assert used(ball, modifier) == ("gpu" if HAS_GPU else "cpu")
    assert np.abs(scenes.evaluated_positions(ball) - before).max() < APART


def test_an_adapter_by_its_name(preferences):
    ball, modifier = squashed_ball()
    names = scenes.part("ui.preferences").adapters(None, bpy.context, "")
    assert names == [device.name for device in isochor.devices() if device.kind != "cpu"]
    preferences.device, preferences.adapter = "NAMED", names[0] if names else "Voodoo 2"
    frames(ball)
    assert used(ball, modifier) == ("gpu" if names else "cpu")


def test_an_adapter_that_is_not_here_is_a_problem_in_plain_words(preferences):
    ball, modifier = squashed_ball()
    expected = frames(ball)
    preferences.device, preferences.adapter = "NAMED", "Voodoo 2"
    found = frames(ball)
    assert all(np.abs(one - other).max() < APART for one, other in zip(found, expected))
    (text,) = scenes.report(ball, modifier).problems
    assert "Voodoo 2" in text
    assert "preferences" in text


@pytest.mark.filterwarnings("ignore:GPU:RuntimeWarning")
def test_two_objects_at_once(preferences):
    preferences.device = "GPU"
    first, one = squashed_ball()
    second, two = squashed_ball()
    second.scale = (1.0, 0.7, 0.9)
    volumes = [scenes.volume(obj.data) for obj in (first, second)]
    for frame in (1, 4, 9):
        bpy.context.scene.frame_set(frame)
        for obj, modifier, whole in ((first, one, volumes[0]), (second, two, volumes[1])):
            assert used(obj, modifier) == ("gpu" if HAS_GPU else "cpu")
            assert abs(scenes.evaluated_volume(obj) / whole - 1) <= 1e-6
