# SPDX-License-Identifier: GPL-3.0-or-later
"""How the correction is found: methods, costs, the limit at folds; and targets that breathe."""

import bpy
import numpy as np
import pytest
import scenes

EXACT = 1e-6
METHODS = ("Balanced", "Sweep", "Gradient", "Nearest")


def shown_with(modifier: bpy.types.NodesModifier, **inputs) -> None:
    for name, value in inputs.items():
        scenes.set_input(modifier, name.replace("_", " "), value)
    bpy.context.view_layer.update()


def squashed(lattice: bpy.types.Object, factor: float = 0.4) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
        point.co_deform.x += 0.2 * point.co_deform.y
    bpy.context.view_layer.update()


def lengths(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> tuple[float, float]:
    """Root of the sum of the squares of how far the correction moved control points, and vertices."""
    report = scenes.report(obj, modifier)
    assert report.problems == ()
    assert scenes.evaluated_volume(obj) == pytest.approx(scenes.volume(obj.data), rel=EXACT)
    moved = scenes.evaluated_positions(obj) - report.embedded.deform(report.asked)
    return float(np.linalg.norm(report.result.control - report.asked)), float(np.linalg.norm(moved))


def test_nearest_moves_the_lattice_least_and_each_keeps_the_volume():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squashed(lattice)
    found = {}
    for method in METHODS:
        shown_with(modifier, Method=method)
        found[method] = lengths(ball, modifier)[0]
        assert scenes.report(ball, modifier).result.method == method.lower()
        assert scenes.report(ball, modifier).notes == []
    assert found["Nearest"] <= min(found.values()) * (1.0 + 1e-9)
    assert found["Gradient"] < found["Sweep"]


def test_costs_of_nearest_keep_small_what_they_are_called_after():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(5)
    modifier = scenes.volume_lattice(ball, lattice, Method="Nearest")
    squashed(lattice)
    found = {}
    for cost in ("Points", "Surface", "Bending"):
        shown_with(modifier, Cost=cost)
        found[cost] = lengths(ball, modifier)
    assert found["Surface"][1] < found["Points"][1]
    assert found["Points"][0] < found["Surface"][0]
    assert found["Bending"] != found["Points"]
    shown_with(modifier, Cost="Surface", Method="Balanced")
    assert scenes.report(ball, modifier).result.method == "balanced"


def test_a_method_that_finds_no_way_is_told():
    """Turned inside out along one axis: the volume changes sign, which geometric steps cannot do."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squashed(lattice, -0.5)
    report = scenes.report(ball, modifier)
    assert report.result.method == "sweep"
    assert any("Balanced" in text and "Sweep" in text for text in report.notes)
    assert scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=1e-5)


def test_unfolded_stops_before_it_turns_space_inside_out_and_says_what_is_missing():
    ball = scenes.sphere()
    lattice = scenes.lattice_object(5)
    modifier = scenes.volume_lattice(ball, lattice, Target=1.0)
    squashed(lattice, 0.6)
    shown_with(modifier, Unfolded=True)
    whole = scenes.volume(ball.data)
    assert scenes.report(ball, modifier).missing == 0.0
    assert scenes.evaluated_volume(ball) == pytest.approx(whole, rel=EXACT)
    shown_with(modifier, Target=0.002, Axes=(1.0, 0.0, 0.0))
    report = scenes.report(ball, modifier)
    native = scenes.part("core.grid").build_lattice(report.grid)
    shown_with(modifier, Unfolded=False)
    freely = scenes.report(ball, modifier)
    assert native.folds(freely.result.control).verdict == "folded"
    assert native.folds(report.result.control).verdict != "folded"
    shown_with(modifier, Unfolded=True)
    report = scenes.report(ball, modifier)
    assert report.missing == pytest.approx(0.002 * whole - scenes.evaluated_volume(ball), abs=1e-5 * whole)
    assert abs(report.missing) > 1e-3 * whole
    assert any("missing" in text for text in report.notes)
    assert "Missing volume" in dict(scenes.part("ui.sidebar").rows(report))


@pytest.mark.parametrize("method", METHODS)
def test_a_keyed_target_breathes_exactly(method):
    ball = scenes.sphere()
    whole = scenes.volume(ball.data)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Method=method)
    squashed(lattice, 0.7)
    path = scenes.part("tool.sockets").data_path(modifier, "Target")
    holder = f'modifiers["{modifier.name}"]' + (path if path.startswith("[") else f".{path}")
    for frame, target in ((1, 1.0), (6, 1.5), (11, 0.8)):
        scenes.set_input(modifier, "Target", target)
        ball.keyframe_insert(holder, frame=frame)
    found = []
    for frame in range(1, 12):
        bpy.context.scene.frame_set(frame)
        target = scenes.get_input(ball.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers[0], "Target")
        assert scenes.evaluated_volume(ball) == pytest.approx(target * whole, rel=EXACT)
        found.append(target)
    assert found[0] == pytest.approx(1.0)
    assert found[5] == pytest.approx(1.5)
    assert found[10] == pytest.approx(0.8)
    assert 1.1 < found[2] < 1.4


def test_a_keyed_amount_inflates_from_what_is_left_to_all_of_it():
    ball = scenes.sphere()
    whole = scenes.volume(ball.data)
    lattice = scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice, Preserve=0.0)
    squashed(lattice, 0.5)
    left = scenes.evaluated_volume(ball)
    path = scenes.part("tool.sockets").data_path(modifier, "Preserve")
    holder = f'modifiers["{modifier.name}"]' + (path if path.startswith("[") else f".{path}")
    for frame, amount in ((1, 0.0), (5, 1.0)):
        scenes.set_input(modifier, "Preserve", amount)
        ball.keyframe_insert(holder, frame=frame)
    for frame in range(1, 6):
        bpy.context.scene.frame_set(frame)
        amount = scenes.get_input(ball.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers[0], "Preserve")
        assert scenes.evaluated_volume(ball) == pytest.approx(left + amount * (whole - left), rel=1e-5)
    assert scenes.evaluated_volume(ball) == pytest.approx(whole, rel=EXACT)
