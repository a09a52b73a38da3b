# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds of the lattice: told in the sidebar, marked by the overlay, looked for when shown and once for each shape."""

import bpy
import isochor
import numpy as np
import pytest
import scenes
from drawn import drawn


def settings():
    return bpy.context.workspace.isochor_overlay


def folding(ball: bpy.types.Object, modifier: bpy.types.NodesModifier):
    memory = scenes.part("tool.state").recall(ball, modifier)
    return memory.folding.of(memory.report)


def sidebar_lines() -> list[str]:
    return drawn(scenes.part("ui.sidebar").VIEW3D_PT_isochor, object=bpy.context.object, mode=bpy.context.mode)


def overlay_shown(fold: str) -> list:
    geometry = scenes.part("tool.overlay_geometry")
    view_layer = bpy.context.view_layer
    pairs = geometry.modifiers_in_view(view_layer, lambda _obj: True, False)
    return geometry.shown(pairs, view_layer.depsgraph, None, geometry.Fold[fold])


@pytest.fixture
def scene():
    """A ball in a lattice of 4 x 4 x 4 points, at rest."""
    ball, lattice = scenes.sphere(), scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    scenes.choose(ball)
    return ball, lattice, modifier


def push_through(lattice: bpy.types.Object) -> None:
    """Pulls one half of the top down through the bottom."""
    for point in lattice.data.points:
        if point.co.z > 0.4 and point.co.x > 0.0:
            point.co_deform.z = -1.5
    bpy.context.view_layer.update()


def test_a_lattice_at_rest_is_proved_to_have_none(scene):
    ball, _lattice, modifier = scene
    assert folding(ball, modifier).verdict == "unfolded"
    lines = sidebar_lines()
    assert lines[lines.index("Folds") + 1] == "None, proved"
    assert not any("folds over itself" in line for line in lines)


@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_a_folded_one_is_told_in_the_sidebar_and_marked_where_it_folds(scene, basis):
    ball, lattice, modifier = scene
    scenes.set_input(modifier, "Basis", basis)
    push_through(lattice)
    found = folding(ball, modifier)
    assert found.verdict == "folded"
    lines = sidebar_lines()
    assert lines[lines.index("Folds") + 1] == f"{len(found.points)} places"
    assert "folds over itself" in " ".join(lines)
    assert np.median(found.parameters[:, 0]) > 0.5
    # They lie in the object's space, where the corrected lattice takes them.
    control = np.asarray(scenes.report(ball, modifier).control).reshape(-1, 3)
    assert np.all((found.points >= control.min(axis=0)) & (found.points <= control.max(axis=0)))


def test_a_flat_one_is_undecided(scene):
    ball, lattice, modifier = scene
    scenes.set_input(modifier, "Preserve", 0.0)
    for point in lattice.data.points:
        point.co_deform.z = 0.0
    bpy.context.view_layer.update()
    assert folding(ball, modifier).verdict == "undecided"
    lines = sidebar_lines()
    assert lines[lines.index("Folds") + 1] == "Undecided"
    assert "cannot be told" in " ".join(lines)


def test_it_is_looked_for_once_for_each_shape(scene, monkeypatch):
    ball, lattice, modifier = scene
    first = folding(ball, modifier)
    asked = []
    core = scenes.part("core.folding")
    plain = core._folds
    monkeypatch.setattr(core, "_folds", lambda shape: asked.append(shape) or plain(shape))
    sidebar_lines()
    bpy.context.scene.frame_set(5)
    ball.location.x = lattice.location.x = 1.0
    bpy.context.view_layer.update()
    sidebar_lines()
    assert folding(ball, modifier) is first
    assert overlay_shown("COMPUTE")[0].folds is first
    assert asked == []
    push_through(lattice)
    assert folding(ball, modifier) is not first
    sidebar_lines()
    assert overlay_shown("COMPUTE")[0].folds is folding(ball, modifier)
    assert len(asked) == 1


def test_frames_and_drawing_without_folds_compute_none(scene, monkeypatch):
    _ball, lattice, _modifier = scene
    core, sidebar = scenes.part("core.folding"), scenes.part("ui.sidebar")

    def never(_shape: object) -> None:
        raise AssertionError("computed")

    monkeypatch.setattr(core, "_folds", never)
    assert not settings().show_folds
    push_through(lattice)
    bpy.context.scene.frame_set(3)
    assert overlay_shown("LEAVE")[0].folds is None
    assert overlay_shown("RECALL")[0].folds is None
    monkeypatch.setattr(sidebar, "is_playing", lambda: True)
    lines = sidebar_lines()
    assert lines[lines.index("Folds") + 1] == "–"


def test_while_playing_a_shape_that_is_known_stays_marked(scene, monkeypatch):
    ball, lattice, modifier = scene
    push_through(lattice)
    known = folding(ball, modifier)
    monkeypatch.setattr(scenes.part("ui.sidebar"), "is_playing", lambda: True)
    lines = sidebar_lines()
    assert lines[lines.index("Folds") + 1] == f"{len(known.points)} places"
    assert overlay_shown("RECALL")[0].folds is known


def test_the_correction_counts(scene):
    """It is the lattice as it shapes the mesh, after the correction, that is looked at."""
    ball, lattice, modifier = scene
    for point in lattice.data.points:
        point.co_deform.z *= 0.4
    bpy.context.view_layer.update()
    report = scenes.report(ball, modifier)
    expected = scenes.part("core.grid").build_lattice(report.grid).folds(report.result.control)
    assert report.largest_displacement > 0.01
    assert folding(ball, modifier).verdict == expected.verdict == "unfolded"


def test_measured_from_the_shape_that_was_bound(scene):
    """With a rest that was set, folds are those of the way from there."""
    ball, lattice, modifier = scene
    for point in lattice.data.points:
        point.co_deform.x += 0.15 * np.sin(9.0 * point.co.z)
    bpy.context.view_layer.update()
    bpy.ops.isochor.set_rest()
    assert scenes.report(ball, modifier).bound is not None
    assert folding(ball, modifier).verdict == "unfolded"
    push_through(lattice)
    assert folding(ball, modifier).verdict == "folded"


def test_marks_are_red_and_orange(scene):
    """Where it folds, and where that cannot be told, as the graphics card gets them."""
    batches = scenes.part("tool.overlay_batches")
    ball, lattice, modifier = scene
    push_through(lattice)
    found = folding(ball, modifier)
    places, tints = batches.marks(found)
    assert places.dtype == tints.dtype == np.float32
    assert len(places) == len(tints) == len(found.points) + len(found.undecided)
    assert np.allclose(places[: len(found.points)], found.points, atol=1e-6)
    assert np.all(tints[: len(found.points)] == np.float32(batches.FOLDED))
    crushed = isochor.Lattice(shape=(4, 4, 4)).folds(np.zeros((4, 4, 4, 3)))
    places, tints = batches.marks(crushed)
    assert (places.shape, tints.shape) == ((1, 3), (1, 4))
    assert np.all(tints == np.float32(batches.UNDECIDED))


def test_nothing_is_said_without_a_lattice(scene):
    ball, _lattice, modifier = scene
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    assert folding(ball, modifier) is None
    assert "Folds" not in sidebar_lines()


def test_the_overlay_s_panels_offer_it(scene):
    panels = scenes.part("ui.overlay")
    space = type("Space", (), {"overlay": type("Overlay", (), {"show_overlays": True})})
    for panel in panels.PANELS:
        assert "show_folds" in drawn(panel, workspace=bpy.context.workspace, space_data=space)
