# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay's data follows the reports; its settings; and what its drawing does where there is nothing to draw on.
The drawing itself needs a window: see the screenshots."""

import subprocess
import sys

import bpy
import numpy as np
import pytest
import scenes
from mathutils import Euler, Matrix


def settings():
    return bpy.context.workspace.isochor_overlay


def everything(_obj: bpy.types.Object) -> bool:
    return True


def shown(only_selected: bool = False, visible=everything) -> list:
    """What a 3D View would draw."""
    geometry = scenes.part("tool.overlay_geometry")
    pairs = geometry.modifiers_in_view(bpy.context.view_layer, visible, only_selected)
    return geometry.shown(pairs, bpy.context.view_layer.depsgraph, settings().wanted())


def squashed_scene() -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.NodesModifier]:
    ball, lattice = scenes.sphere(), scenes.lattice_object(4)
    modifier = scenes.volume_lattice(ball, lattice)
    squash(lattice, 0.5)
    return ball, lattice, modifier


def squash(lattice: bpy.types.Object, factor: float) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def test_it_is_off_until_asked_for_and_belongs_to_the_workspace(tmp_path):
    assert not settings().show
    squashed_scene()
    settings().show = True
    settings().divisions = 5
    bpy.ops.ed.undo_push(message="before")
    bpy.data.objects["Ball"].location.x = 1.0
    bpy.ops.ed.undo_push(message="moved")
    settings().divisions = 6
    bpy.ops.ed.undo()
    assert bpy.data.objects["Ball"].location.x == 0.0
    assert (settings().show, settings().divisions) == (True, 6)
    name, place = bpy.context.workspace.name, str(tmp_path / "overlay.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    kept = bpy.data.workspaces[name].isochor_overlay
    assert (kept.show, kept.divisions) == (True, 6)


def test_the_drawing_is_the_report_s_and_the_same_object_until_it_changes():
    ball, lattice, modifier = squashed_scene()
    (first,) = shown()
    report = scenes.report(ball, modifier)
    assert np.allclose(first.drawing.points, np.asarray(report.control).reshape(-1, 3), atol=1e-6)
    assert first.largest == pytest.approx(report.largest_displacement, rel=1e-6)
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(2)
    assert shown()[0].drawing is first.drawing
    squash(lattice, 0.9)
    (second,) = shown()
    assert second.drawing is not first.drawing
    report = scenes.report(ball, modifier)
    assert np.allclose(second.drawing.points, np.asarray(report.control).reshape(-1, 3), atol=1e-6)
    assert second.largest > first.largest


def test_settings_that_ask_for_other_lines_make_another_drawing():
    squashed_scene()
    (before,) = shown()
    assert len(before.drawing.isolines) == 0
    settings().show_isolines = True
    settings().divisions, settings().samples = 2, 4
    counts = []
    for inside in (False, True):
        settings().inside = inside
        counts.append(len(shown()[0].drawing.isolines))
    assert counts == [3 * 8 * 4 * 2, 3 * 9 * 4 * 2]
    assert shown()[0].drawing is shown()[0].drawing
    assert np.array_equal(shown()[0].drawing.points, before.drawing.points)


def test_it_stands_where_the_evaluated_object_stands():
    ball, lattice, _modifier = squashed_scene()
    parent = scenes.linked(bpy.data.objects.new("Parent", None))
    ball.parent = lattice.parent = parent
    parent.matrix_world = Matrix.LocRotScale((1.0, 2.0, 3.0), Euler((0.4, 0.5, 0.6)), (2.0, 2.0, 2.0))
    bpy.context.view_layer.update()
    (found,) = shown()
    world = np.array(found.to_world)
    assert np.allclose(world, np.array(parent.matrix_world) @ np.array(ball.matrix_basis), atol=1e-6)
    points = found.drawing.points @ world[:3, :3].T + world[:3, 3]
    low, high = scenes.evaluated_positions(ball).min(axis=0), scenes.evaluated_positions(ball).max(axis=0)
    corners = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    around = corners @ world[:3, :3].T + world[:3, 3]
    middle = points.mean(axis=0)
    assert np.linalg.norm(middle - around.mean(axis=0)) < 0.2
    assert found.largest == pytest.approx(2.0 * np.linalg.norm(found.drawing.moved, axis=1).max(), rel=1e-5)


def test_which_objects_it_draws():
    ball, lattice, modifier = squashed_scene()
    other = scenes.sphere(name="Other")
    scenes.volume_lattice(other, scenes.lattice_object(4, name="Second"))
    third = scenes.sphere(name="Third")
    assert len(shown()) == 2
    assert shown(only_selected=True) == []
    for chosen in (ball, lattice):
        scenes.choose(chosen)
        assert [one.key[0] for one in shown(only_selected=True)] == [ball.session_uid]
    assert [one.key[0] for one in shown(visible=lambda obj: obj != ball)] == [other.session_uid]
    ball.hide_set(True)
    assert [one.key[0] for one in shown(visible=lambda obj: obj.visible_get())] == [other.session_uid]
    ball.hide_set(False)
    modifier.show_viewport = False
    assert [one.key[0] for one in shown()] == [other.session_uid]
    assert third.modifiers.values() == []


def test_nothing_is_drawn_of_what_has_no_lattice():
    ball, _lattice, modifier = squashed_scene()
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    assert scenes.report(ball, modifier).problems
    assert shown() == []


def test_an_uncorrected_lattice_is_drawn_unmoved():
    _ball, lattice, modifier = squashed_scene()
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    (found,) = shown()
    assert found.largest == 0.0
    assert np.allclose(found.drawing.points[:, 2].max(), 0.25 * lattice.scale.z, atol=1e-6)


@pytest.mark.parametrize("shape", [(1, 4, 4), (2, 1, 1), (1, 1, 1)])
def test_flat_lattices_have_drawings_too(shape):
    ball = scenes.sphere()
    scenes.volume_lattice(ball, scenes.lattice_object(shape), Outside="Extend")
    settings().show_isolines = True
    (found,) = shown()
    assert len(found.drawing.points) == np.prod(shape)
    assert np.isfinite(found.drawing.isolines).all()


def test_deleted_and_undone_objects_leave_nothing_behind():
    geometry = scenes.part("tool.overlay_geometry")
    ball, lattice, _modifier = squashed_scene()
    bpy.ops.ed.undo_push(message="before")
    (found,) = shown()
    keys = geometry.keys_of_file()
    assert keys == {found.key}
    bpy.data.objects.remove(lattice)
    bpy.context.view_layer.update()
    assert shown() == []
    bpy.data.objects.remove(ball)
    assert geometry.keys_of_file() == set()
    assert shown() == []
    bpy.ops.ed.undo_push(message="deleted")
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    (again,) = shown()
    assert np.allclose(again.drawing.points, found.drawing.points)
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.isochor.remove()
    assert shown() == []


def test_turning_it_on_warns_of_nothing_and_computes_nothing_anew(capfd):
    ball, _lattice, modifier = squashed_scene()
    memory = scenes.part("tool.state").recall(ball, modifier)
    written = memory.written
    capfd.readouterr()
    settings().show = True
    settings().show_isolines = True
    bpy.context.view_layer.update()
    told = capfd.readouterr()
    assert (told.out, told.err) == ("", "")
    assert memory.written is written


def test_a_fault_while_drawing_is_told_once(monkeypatch, caplog):
    overlay = scenes.part("tool.overlay")
    squashed_scene()
    settings().show = True

    def fail(*_given: object) -> None:
        raise RuntimeError("the graphics card is on holiday")

    class Context:
        workspace = bpy.context.workspace
        space_data = type("Space", (), {"overlay": type("Overlay", (), {"show_overlays": True})})

    monkeypatch.setattr(overlay, "current_context", Context)
    for _ in range(3):
        overlay.guarded(fail)
    assert [str(record.exc_info[1]) for record in caplog.records] == ["the graphics card is on holiday"]
    settings().show = False
    overlay.clear()
    overlay.guarded(fail)
    assert len(caplog.records) == 1


def test_without_a_window_its_drawing_does_nothing(caplog):
    """In the background there is no 3D View in the context, and no graphics."""
    overlay = scenes.part("tool.overlay")
    squashed_scene()
    settings().show = True
    overlay.draw_view()
    overlay.draw_pixels()
    assert caplog.records == []


def test_it_is_registered_and_taken_away_whole():
    import importlib

    extension = importlib.import_module(scenes.MODULE)
    settings().show = True
    for _ in range(2):
        extension.unregister()
        assert not hasattr(bpy.types.WorkSpace, "isochor_overlay")
        assert not hasattr(bpy.types, "VIEW3D_PT_isochor_overlay")
        assert scenes.part("tool.overlay")._handles == []
        extension.register()
    assert settings().show
    assert len(scenes.part("tool.overlay")._handles) == 2


def test_core_needs_no_blender():
    """The geometry and the picture can be made where there is no Blender."""
    core = scenes.part("core.isolines").__file__.rpartition("core")[0]
    program = (
        "import sys, types; sys.modules['bpy'] = None; home = types.ModuleType('home');"
        f"home.__path__ = [{core!r}]; sys.modules['home'] = home;"
        "import home.core.isolines, home.core.curve_image, home.core.volume_curve; print('made')"
    )
    import isochor

    place = isochor.__file__.rpartition("isochor")[0]
    environment = {"PYTHONPATH": f"{place}:{np.__file__.rpartition('numpy')[0]}"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.stdout == "made\n", done.stderr
