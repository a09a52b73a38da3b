# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.measure_volume and isochor.volume_image: the numbers, what is kept, undo, and what is refused."""

import bpy
import numpy as np
import pytest
import scenes


def squashed_ball(frames: int = 9) -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.NodesModifier]:
    """A ball whose lattice is squashed and sheared over the frames; the scene's range is those frames."""
    ball = scenes.sphere()
    lattice = scenes.lattice_object(4)
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash")
    for point in key.data:
        point.co.z *= 0.35
        point.co.x += 0.2 * point.co.z + 0.3 * point.co.y**2
    for frame, value in ((1, 0.0), (frames, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    modifier = scenes.volume_lattice(ball, lattice)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, frames
    bpy.context.scene.frame_set(3)
    return ball, lattice, modifier


def kept(modifier: bpy.types.NodesModifier):
    """The curve as a script reads it from the file."""
    result = scenes.get_input(modifier, "Viewport Result")
    found = result.get("isochor_volume_curve")
    return None if found is None else {name: np.array(found[name], np.float64) for name in found.keys()}  # noqa: SIM118


def plain_volume(ball: bpy.types.Object, modifier: bpy.types.NodesModifier) -> float:
    """Volume of the mesh that Blender shows in this frame with the correction off."""
    scenes.set_input(modifier, "Preserve", 0.0)
    bpy.context.view_layer.update()
    found = scenes.evaluated_volume(ball)
    scenes.set_input(modifier, "Preserve", 1.0)
    bpy.context.view_layer.update()
    return found


def test_the_numbers_are_those_of_the_meshes_shown():
    ball, _lattice, modifier = squashed_ball()
    bpy.context.scene.frame_set(3, subframe=0.25)
    assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    assert (bpy.context.scene.frame_current, bpy.context.scene.frame_subframe) == (3, 0.25)
    found = kept(modifier)
    assert found["frames"].tolist() == list(range(1, 10))
    whole = scenes.volume(ball.data)
    for place, frame in enumerate(range(1, 10)):
        bpy.context.scene.frame_set(frame)
        assert found["after"][place] == pytest.approx(scenes.evaluated_volume(ball), rel=1e-9)
        assert found["before"][place] == pytest.approx(plain_volume(ball, modifier), rel=1e-9)
    assert found["target"] == pytest.approx(np.full(9, whole), rel=1e-6)
    assert found["before"][-1] < 0.5 * whole
    assert np.abs(found["after"] / found["target"] - 1.0).max() <= 1e-6


@pytest.mark.parametrize("step", [1, 3])
def test_range_and_step_are_those_asked_for(step):
    _ball, _lattice, modifier = squashed_ball()
    assert bpy.ops.isochor.measure_volume(frame_start=-2, frame_end=6, step=step) == {"FINISHED"}
    assert kept(modifier)["frames"].tolist() == list(range(-2, 7, step))


def test_what_the_lattice_alone_loses_is_known_with_preserve_off():
    ball, _lattice, modifier = squashed_ball()
    whole = scenes.volume(ball.data)
    scenes.set_input(modifier, "Preserve", 0.0)
    scenes.set_input(modifier, "Target", 1.25)
    assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    found = kept(modifier)
    bpy.context.scene.frame_set(9)
    assert found["after"][-1] == pytest.approx(scenes.evaluated_volume(ball), rel=1e-9)
    assert found["before"] == pytest.approx(found["after"], rel=1e-12)
    assert found["target"] == pytest.approx(np.full(9, 1.25 * whole), rel=1e-6)


def test_inside_out_meshes_have_negative_volumes_and_positive_percents():
    ball, _lattice, modifier = squashed_ball()
    ball.data.flip_normals()
    scenes.set_input(modifier, "Reference", "Incoming")
    assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    curve = scenes.part("tool.volume_curve").read(modifier)
    assert (curve.after < 0.0).all()
    assert curve.after_percent == pytest.approx(np.full(9, 100.0), rel=1e-6)
    assert 0.0 < curve.before_percent[-1] < 50.0


def test_several_objects_and_a_selected_lattice_are_measured_in_one_walk():
    ball, lattice, modifier = squashed_ball()
    other = scenes.sphere(name="Other")
    second = scenes.volume_lattice(other, lattice, Axes=(1.0, 1.0, 0.0))
    scenes.choose(lattice)
    frames = []
    bpy.app.handlers.frame_change_post.append(lambda scene, _depsgraph: frames.append(scene.frame_current))
    try:
        assert bpy.ops.isochor.measure_volume() == {"FINISHED"}
    finally:
        bpy.app.handlers.frame_change_post.pop()
    assert frames == [*range(1, 10), 3]
    assert kept(modifier)["before"] == pytest.approx(kept(second)["before"])
    assert scenes.evaluated_volume(ball) == pytest.approx(scenes.evaluated_volume(other), rel=1e-6)


def test_undo_takes_the_curve_back_in_one_step():
    _ball, _lattice, modifier = squashed_ball()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.isochor.measure_volume()
    bpy.ops.isochor.volume_image()
    bpy.ops.ed.undo_push(message="measured")
    assert kept(modifier) is not None
    assert len(bpy.data.images) == 1
    bpy.ops.ed.undo()
    modifier = bpy.data.objects["Ball"].modifiers[0]
    assert kept(modifier) is None
    assert len(bpy.data.images) == 0
    bpy.ops.ed.redo()
    assert kept(bpy.data.objects["Ball"].modifiers[0]) is not None


def test_the_curve_is_saved_with_the_file(tmp_path):
    _ball, _lattice, modifier = squashed_ball()
    bpy.ops.isochor.measure_volume()
    bpy.ops.isochor.volume_image()
    before = kept(modifier)
    place = str(tmp_path / "measured.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    bpy.ops.wm.open_mainfile(filepath=place)
    after = kept(bpy.data.objects["Ball"].modifiers[0])
    assert all(np.array_equal(before[name], after[name]) for name in before)
    image = bpy.data.images["Ball Volume"]
    assert tuple(image.size) == (1600, 800)
    pixels = np.empty(1600 * 800 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    assert len(np.unique(pixels)) > 20


def test_the_image_shows_the_measured_curve():
    curve_image = scenes.part("core.curve_image")
    _ball, _lattice, modifier = squashed_ball()
    bpy.ops.isochor.measure_volume()
    assert bpy.ops.isochor.volume_image() == {"FINISHED"}
    image = bpy.data.images["Ball Volume"]
    pixels = np.empty(1600 * 800 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    shown = np.rint(pixels.reshape(800, 1600, 4)[::-1, :, :3] * 255).astype(int)

    def rows_of(colour: tuple[int, int, int], columns: slice) -> np.ndarray:
        close = np.abs(shown[130:, columns] - colour).sum(axis=2) < 60
        return np.flatnonzero(close.any(axis=1)) + 130

    level = rows_of(curve_image.LIGHT.corrected, slice(800, 1500))
    lowest = rows_of(curve_image.LIGHT.plain, slice(1540, 1551))
    middle = rows_of(curve_image.LIGHT.plain, slice(820, 831))
    assert np.ptp(level) <= 10
    assert level.max() + 20 < middle.min() < middle.max() + 20 < lowest.min()
    percents = scenes.part("tool.volume_curve").read(modifier).before_percent
    assert percents[0] > percents[4] > percents[-1]


def test_measuring_again_replaces_curve_and_image():
    _ball, lattice, modifier = squashed_ball()
    bpy.ops.isochor.measure_volume()
    bpy.ops.isochor.volume_image()
    lattice.data.shape_keys.key_blocks["Squash"].slider_max = 1.0
    lattice.data.shape_keys.animation_data_clear()
    lattice.data.shape_keys.key_blocks["Squash"].value = 0.0
    bpy.ops.isochor.measure_volume(frame_end=4)
    bpy.ops.isochor.volume_image()
    assert kept(modifier)["before"] == pytest.approx(kept(modifier)["target"], rel=1e-6)
    assert len(kept(modifier)["frames"]) == 4
    assert [image.name for image in bpy.data.images] == ["Ball Volume"]


def refused(text: str, **given: int) -> None:
    """The operator refuses with this text, and neither frame nor curve changes."""
    scene = bpy.context.scene
    frame = scene.frame_current
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.isochor.measure_volume(**given)
    assert scene.frame_current == frame
    assert not any("isochor_volume_curve" in obj for obj in bpy.data.objects)


def test_a_range_that_ends_before_it_begins_is_refused():
    squashed_ball()
    refused(r"The last frame \(2\) comes before the first \(5\)", frame_start=5, frame_end=2)


def test_edit_mode_is_refused():
    squashed_ball()
    bpy.ops.object.mode_set(mode="EDIT")
    refused("“Ball” is in Edit Mode: leave it first")


def test_a_modifier_that_is_off_is_refused():
    _ball, _lattice, modifier = squashed_ball()
    modifier.show_viewport = False
    refused("switched off on “Ball”")


@pytest.mark.parametrize("hide", ["hide_viewport", "excluded"])
def test_an_object_that_is_not_evaluated_is_refused(hide):
    ball, _lattice, _modifier = squashed_ball()
    if hide == "hide_viewport":
        ball.hide_viewport = True
    else:
        aside = bpy.data.collections.new("Aside")
        bpy.context.scene.collection.children.link(aside)
        bpy.context.scene.collection.objects.unlink(ball)
        aside.objects.link(ball)
        bpy.context.view_layer.layer_collection.children["Aside"].exclude = True
    with bpy.context.temp_override(object=ball, active_object=ball, selected_objects=[ball]):
        refused("“Ball” is hidden, or in no collection of this view layer")


def test_an_open_mesh_is_refused_with_the_reason():
    ball = scenes.sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    ball.data.polygons[0].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="FACE")
    bpy.ops.object.mode_set(mode="OBJECT")
    scenes.volume_lattice(ball, scenes.lattice_object(4))
    bpy.context.scene.frame_end = 3
    refused("“Ball” has no volume to measure in any of these frames: .*hole")


def test_nothing_selected_or_nothing_measured_yet():
    assert not bpy.ops.isochor.measure_volume.poll()
    squashed_ball()
    assert bpy.ops.isochor.measure_volume.poll()
    assert not bpy.ops.isochor.volume_image.poll()
    bpy.ops.isochor.measure_volume(frame_end=2)
    assert bpy.ops.isochor.volume_image.poll()


def test_linked_objects_are_refused(tmp_path):
    squashed_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball"]
    scenes.linked(here.objects[0])
    with pytest.raises(RuntimeError, match="“Ball” is linked from another file"):
        bpy.ops.isochor.measure_volume()


def test_a_frame_that_cannot_be_measured_is_a_gap():
    _ball, _lattice, modifier = squashed_ball()
    curve_type = scenes.part("core.volume_curve")
    unknown = curve_type.Sample(2, *curve_type.UNKNOWN)
    curve = curve_type.VolumeCurve.of([curve_type.Sample(1, 2.0, 1.0, 2.0), unknown])
    scenes.part("tool.volume_curve").keep(modifier, curve)
    again = scenes.part("tool.volume_curve").read(modifier)
    assert again.signature == curve.signature
    assert again.is_known
    assert again.before_percent[0] == 50.0
    assert np.isnan(again.before_percent[1])
    assert not curve_type.VolumeCurve.of([unknown]).is_known


def test_sidebar_tells_the_worst_frames():
    ball, _lattice, modifier = squashed_ball()
    bpy.ops.isochor.measure_volume()
    told = dict(scenes.part("ui.volume_curve").rows(scenes.part("tool.volume_curve").read(modifier)))
    bpy.context.scene.frame_set(9)
    expected = 100.0 * (plain_volume(ball, modifier) / scenes.volume(ball.data) - 1.0)
    assert told["Frames"] == "1 to 9"
    assert float(told["Lattice alone"].split(" %")[0]) == pytest.approx(expected, abs=0.06)
    assert abs(float(told["Corrected"].split(" %")[0])) < 1e-4
