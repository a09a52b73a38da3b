# SPDX-License-Identifier: GPL-3.0-or-later
"""Ferrier's car: of four tied blocks one crumples, the rest keeps still to the last bit, and the volume is kept."""

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import scenes

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon" / "demo"), str(ROOT / "blend_fixtures")]

import car_crash  # noqa: E402


@pytest.fixture
def crash():
    scenes.empty_file()
    return car_crash.Crash(bpy.context.scene)


def error(crash: car_crash.Crash) -> float:
    return abs(scenes.evaluated_volume(crash.car) / crash.whole - 1.0)


def test_model_is_closed_and_of_five_pieces(crash):
    assert crash.model.is_closed
    assert 3000 < len(crash.model.points) < 15000
    edges = np.concatenate([crash.model.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    piece = np.arange(len(crash.model.points))
    before = None
    while before is None or not np.array_equal(piece, before):
        before = piece.copy()
        np.minimum.at(piece, edges[:, 0], piece[edges[:, 1]])
        np.minimum.at(piece, edges[:, 1], piece[edges[:, 0]])
    assert len(np.unique(piece)) == 5
    assert scenes.volume(crash.car.data) > 0.0


def test_blocks_are_tied_in_a_row_and_the_front_corrects(crash):
    record = scenes.part("tool.tie_record")
    assert [len(record.of(crash.lattices[name])) for name in car_crash.NAMES] == [1, 2, 2, 1]
    preserve = [scenes.get_input(modifier, "Preserve") for modifier in crash.car.modifiers]
    assert preserve == [0.0, 0.0, 0.0, 1.0]
    assert crash.last.name == "Front"


def test_front_crumples_the_rest_keeps_still_and_the_volume_is_kept(crash):
    for frame in (1, car_crash.HIT, 12, car_crash.STOPPED, car_crash.LAST):
        bpy.context.scene.frame_set(frame)
        assert crash.moved_behind() == 0.0
        assert error(crash) <= 1e-6
        assert scenes.report(crash.car, crash.last).problems == ()
    assert np.abs(crash.moved()).max() > 0.4
    wheels = crash.model.values["wheel"] < 0.0
    assert np.abs(crash.moved()[wheels]).max() == 0.0
    crash.put(Preserve=0.0)
    assert error(crash) > 0.02
    crash.put(Preserve=1.0)


def test_what_reaches_the_joint_goes_on_behind_it_without_a_crease(crash):
    bpy.context.scene.frame_set(car_crash.LAST)
    key = crash.lattices["Front"].data.shape_keys.key_blocks["Crumple"]
    layers = car_crash.POINTS["Front"][0]
    kept = [tuple(point.co) for point in key.data]
    for index, point in enumerate(key.data):
        if index % layers >= layers - 2:
            point.co.z += 0.1
    crash.lattices["Front"].data.update_tag()
    bpy.context.view_layer.update()
    assert crash.moved_behind() > 0.03
    assert error(crash) <= 1e-6
    for point, place in zip(key.data, kept, strict=True):
        point.co = place
    crash.lattices["Front"].data.update_tag()
    bpy.context.view_layer.update()
