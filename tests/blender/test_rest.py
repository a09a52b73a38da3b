# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume kept since the modifier was added: when it is no longer the mesh's, and what renders take."""

import bpy
import numpy as np
import pytest
import scenes

EDITED = "The mesh was edited since the lattice was added"


def kept(modifier: bpy.types.NodesModifier, mode: str) -> float | None:
    return scenes.get_input(modifier, f"{mode} Result").get("isochor_rest_volume")


def notices(obj: bpy.types.Object) -> list[str]:
    return [text for text in scenes.report(obj, obj.modifiers[-1]).problems if text.startswith(EDITED)]


def squash(lattice: bpy.types.Object, factor: float = 0.5) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def ball_in_a_lattice() -> tuple[bpy.types.Object, bpy.types.Object]:
    ball = scenes.sphere()
    ball.scale = (2.0, 2.0, 2.0)
    lattice = scenes.lattice_object(4, size=6.0)
    scenes.volume_lattice(ball, lattice)
    squash(lattice)
    return ball, lattice


def test_applied_scale_is_told_and_the_frame_computed_all_the_same(tmp_path):
    ball, lattice = ball_in_a_lattice()
    before = scenes.volume(ball.data)
    assert notices(ball) == []
    scenes.choose(ball)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bpy.context.view_layer.update()
    assert len(notices(ball)) == 1
    assert scenes.evaluated_volume(ball) == pytest.approx(before, rel=1e-6)
    bpy.context.scene.frame_set(2)
    squash(lattice, 0.9)
    assert len(notices(ball)) == 1
    place = str(tmp_path / "edited.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    ball = bpy.data.objects["Ball"]
    bpy.context.scene.frame_set(3)
    assert len(notices(ball)) == 1
    scenes.set_input(ball.modifiers[0], "Reference", "Incoming")
    bpy.context.view_layer.update()
    assert notices(ball) == []
    assert scenes.evaluated_volume(ball) == pytest.approx(8.0 * before, rel=1e-6)


def test_edit_mode_change_is_told_and_its_undoing_too():
    ball, _lattice = ball_in_a_lattice()
    for factor, told in ((1.5, 1), (1 / 1.5, 0)):
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.resize(value=(factor, 1.0, 1.0))
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        assert len(notices(ball)) == told


def test_edits_that_keep_the_volume_are_not_told():
    ball, lattice = ball_in_a_lattice()
    points = scenes.positions(ball.data)
    turn = np.array([(0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)])
    for moved in (points @ turn.T, points + (0.4, -0.3, 0.2), points + (300.0, 0.0, 0.0)):
        ball.data.attributes["position"].data.foreach_set("vector", moved.astype(np.float32).reshape(-1))
        ball.data.update()
        bpy.context.view_layer.update()
        assert notices(ball) == []
    ball.data.uv_layers.new(name="UV")
    squash(lattice, 0.9)
    assert notices(ball) == []


def test_the_look_at_an_edit_is_not_taken_in_every_frame(monkeypatch):
    ball, lattice = ball_in_a_lattice()
    results = scenes.part("tool.results")
    looks = []
    look = results.is_edited
    monkeypatch.setattr(results, "is_edited", lambda *given: looks.append(1) or look(*given))
    for frame in range(2, 8):
        squash(lattice, 0.95)
        bpy.context.scene.frame_set(frame)
    assert looks == []
    ball.data.vertices[0].co.x += 0.1
    ball.data.update()
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(9)
    assert looks == [1]
    assert len(notices(ball)) == 1


def test_added_in_edit_mode_the_render_keeps_what_the_viewport_keeps():
    ball = scenes.sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.isochor.add()
    modifier = ball.modifiers.active
    assert kept(modifier, "Viewport") is None
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert kept(modifier, "Viewport") == pytest.approx(scenes.volume(ball.data), rel=1e-6)
    assert kept(modifier, "Render") == kept(modifier, "Viewport")


def test_copied_to_another_mesh_the_render_keeps_what_the_viewport_keeps():
    ball, _lattice = ball_in_a_lattice()
    modifier = ball.modifiers[0]
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.7)
    other = bpy.context.object
    new = other.modifiers.new("Volume Lattice", "NODES")
    new.node_group = modifier.node_group
    for name in ("Lattice", "Viewport Result", "Render Result", "Slot"):
        scenes.set_input(new, name, scenes.get_input(modifier, name))
    bpy.context.view_layer.update()
    assert kept(new, "Viewport") == pytest.approx(scenes.volume(other.data), rel=1e-6)
    assert kept(new, "Render") == kept(new, "Viewport")
    assert kept(modifier, "Render") == kept(modifier, "Viewport") != kept(new, "Viewport")


def test_where_renders_see_another_mesh_its_volume_is_measured_on_saving(tmp_path):
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    subdivision = cube.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 1, 3
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.isochor.add()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    modifier = cube.modifiers.active
    assert kept(modifier, "Viewport") is not None
    assert kept(modifier, "Render") is None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "farm.blend"))
    assert (subdivision.levels, subdivision.render_levels) == (1, 3)
    modifier.show_viewport = False
    subdivision.levels = 3
    bpy.context.view_layer.update()
    assert kept(modifier, "Render") == pytest.approx(scenes.evaluated_volume(cube), rel=1e-6)
    assert abs(kept(modifier, "Render") / kept(modifier, "Viewport") - 1.0) > 1e-3
