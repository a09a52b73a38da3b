# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.simulate and isochor.free_simulation: the lattice as jelly, as an animator meets it."""

import bpy
import numpy as np
import pytest
import scenes
from test_render import MeasuringEngine

END = 40


def dropped_ball(height: float = 1.8, **settings) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball of radius 1 with a Volume Lattice at that height, simulated to frame END; ball and lattice."""
    ball = scenes.sphere(32, 20)
    ball.location.z = height
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, END
    bpy.context.view_layer.update()
    bpy.ops.isochor.add()
    lattice = scenes.get_input(ball.modifiers.active, "Lattice")
    assert simulated(**settings) == {"FINISHED"}
    return ball, lattice


def simulated(**settings) -> set[str]:
    return bpy.ops.isochor.simulate("EXEC_DEFAULT", True, **settings)


def world(ball: bpy.types.Object, frame: float) -> np.ndarray:
    """(V, 3) vertices in world space at a frame."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    return scenes.evaluated_positions(ball) @ np.array(ball.matrix_world)[:3, :3].T + np.array(ball.location)


def refusal(**settings) -> str:
    with pytest.raises(RuntimeError) as caught:
        simulated(**settings)
    return str(caught.value)


def test_the_ball_falls_in_real_time_lands_squashes_and_keeps_its_volume():
    ball, _lattice = dropped_ball()
    rest = scenes.volume(ball.data)
    lows, heights, errors = [], [], []
    for frame in range(1, END + 1):
        points = world(ball, frame)
        lows.append(points[:, 2].min())
        heights.append(np.ptp(points[:, 2]))
        errors.append(abs(scenes.evaluated_volume(ball) / rest - 1.0))
    for frame in (1, 4, 8):
        seconds = (frame - 1) / 24.0
        assert lows[frame - 1] == pytest.approx(0.8 - 9.81 / 2.0 * seconds**2, abs=2e-3)
    assert max(errors) < 1e-6
    assert min(lows) > -2e-3, "it sinks into the ground"
    assert min(lows) < 2e-3, "it does not reach the ground"
    assert min(heights) < 0.85 * heights[0], "it is not squashed"
    assert max(heights[20:]) > 1.02 * heights[0], "it does not stretch after"


def test_frames_do_not_depend_on_each_other():
    ball, _lattice = dropped_ball()
    played = [world(ball, frame) for frame in range(1, END + 1)]
    for frame in (30, 12, END, 1):
        assert np.array_equal(world(ball, frame), played[frame - 1])
    between = world(ball, 11.5)
    assert np.abs(between - (played[10] + played[11]) / 2.0).max() < 0.02


def test_the_same_bits_twice_and_after_saving(tmp_path):
    ball, _lattice = dropped_ball(spin=(0.3, 0.0, 1.0), velocity=(1.0, 0.0, 0.0))
    first = world(ball, 33)
    assert simulated(spin=(0.3, 0.0, 1.0), velocity=(1.0, 0.0, 0.0)) == {"FINISHED"}
    assert np.array_equal(world(ball, 33), first)
    place = str(tmp_path / "jelly.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    bpy.ops.wm.open_mainfile(filepath=place)
    ball = bpy.data.objects["Ball"]
    world(ball, 2)
    assert np.array_equal(world(ball, 33), first)
    scenes.choose(ball)
    assert bpy.ops.isochor.free_simulation() == {"FINISHED"}
    assert scenes.get_input(ball.modifiers.active, "Lattice").data.shape_keys is None


def test_renders_get_the_same_frames():
    ball, _lattice = dropped_ball()
    scene = bpy.context.scene
    bpy.utils.register_class(MeasuringEngine)
    try:
        MeasuringEngine.noted.clear()
        scene.render.engine = MeasuringEngine.bl_idname
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        for frame in (14, 20):
            scene.frame_set(frame)
            bpy.ops.render.render()
        noted = {place: points for place, _count, _volume, points in MeasuringEngine.noted}
    finally:
        bpy.utils.unregister_class(MeasuringEngine)
    for frame in (14, 20):
        scene.frame_set(frame)
        assert np.array_equal(noted[frame], scenes.evaluated_positions(ball))


def test_one_undo_step_and_redo():
    ball = scenes.sphere()
    bpy.context.scene.frame_end = 10
    bpy.ops.isochor.add()
    bpy.ops.ed.undo_push(message="added")
    assert simulated() == {"FINISHED"}
    bpy.ops.ed.undo()
    lattice = bpy.data.objects["Ball Lattice"]
    assert lattice.data.shape_keys is None
    assert len(bpy.data.lattices) == 1
    bpy.ops.ed.redo()
    assert len(bpy.data.objects["Ball Lattice"].data.shape_keys.key_blocks) == 10
    assert ball is not None


def test_the_lattice_s_own_keys_and_hooks_are_kept_and_come_back():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    lattice = scenes.get_input(ball.modifiers.active, "Lattice")
    lattice.shape_key_add(name="Basis")
    wide = lattice.shape_key_add(name="Wide")
    for point in wide.data:
        point.co.x *= 1.5
    for frame, value in ((1, 0.0), (6, 1.0)):
        wide.value = value
        wide.keyframe_insert("value", frame=frame)
    hook = lattice.modifiers.new("Hook", "HOOK")
    hook.object = bpy.data.objects.new("Empty", None)
    bpy.context.scene.collection.objects.link(hook.object)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 12
    own = lattice.data
    before = [world(ball, frame) for frame in range(1, 13)]
    assert simulated(frame_start=5, use_ground=False) == {"FINISHED"}
    for frame in range(1, 6):
        assert np.abs(world(ball, frame) - before[frame - 1]).max() < 1e-6, "the frames before are the animator's"
    assert world(ball, 12)[:, 2].mean() < before[11][:, 2].mean() - 0.3
    assert (hook.show_viewport, hook.show_render) == (False, False)
    assert bpy.ops.isochor.free_simulation() == {"FINISHED"}
    assert lattice.data == own
    assert (hook.show_viewport, hook.show_render) == (True, True)
    for frame in range(1, 13):
        assert np.array_equal(world(ball, frame), before[frame - 1])
    assert len(bpy.data.lattices) == 1
    assert not bpy.ops.isochor.free_simulation.poll()


def test_a_throw_in_the_animation_goes_on():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    lattice = scenes.get_input(ball.modifiers.active, "Lattice")
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 25
    carrier = scenes.linked(bpy.data.objects.new("Carrier", None))
    for child in (ball, lattice):
        child.parent = carrier
    for frame, x in ((1, 0.0), (13, 3.0), (14, 3.0)):
        carrier.location.x = x
        carrier.keyframe_insert("location", index=0, frame=frame)
    curve = scenes.part("tool.drivers").keys_of(carrier, "location")
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    scenes.choose(ball)
    speed = 3.0 / 12.0 * 24.0
    assert simulated(frame_start=13, use_ground=False) == {"FINISHED"}

    def middle(frame: int) -> np.ndarray:
        scene.frame_set(frame)
        matrix = np.array(ball.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
        return (scenes.evaluated_positions(ball) @ matrix[:3, :3].T + matrix[:3, 3]).mean(axis=0)

    start, later = middle(13), middle(25)
    assert later[0] - start[0] == pytest.approx(speed * 0.5, abs=0.02)
    assert later[2] - start[2] == pytest.approx(-9.81 / 2.0 * 0.25, abs=0.02)
    assert simulated(frame_start=13, use_ground=False, use_motion=False) == {"FINISHED"}
    assert middle(25)[0] - middle(13)[0] == pytest.approx(0.0, abs=0.02)


def test_pinned_points_follow_the_animation_and_the_rest_hangs_on():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    lattice = scenes.get_input(ball.modifiers.active, "Lattice")
    group = lattice.vertex_groups.new(name="Hold")
    group.add(list(range(48, 64)), 1.0, "REPLACE")
    bpy.context.scene.frame_end = 30
    assert simulated(pinned="Hold", use_ground=False) == {"FINISHED"}
    bpy.context.scene.frame_set(30)
    shape = np.array(
        [tuple(point.co_deform) for point in lattice.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.points]
    )
    rest = np.array([tuple(point.co) for point in lattice.data.points])
    assert np.abs(shape[48:] - rest[48:]).max() < 1e-6
    assert 0.01 < (rest[:16] - shape[:16])[:, 2].mean() < 0.5


def test_a_tilted_ground_object_makes_it_roll_down():
    ground = scenes.mesh_object("Slope", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [(0, 1, 2, 3)])
    ground.rotation_euler.y = 0.3
    bpy.context.view_layer.update()
    ball, _lattice = dropped_ball(height=1.3, ground_object="Slope")
    normal = np.array(ground.matrix_world)[:3, 2]
    lows = [(world(ball, frame) @ normal).min() for frame in range(1, END + 1)]
    assert -2e-3 < min(lows) < 2e-3
    assert world(ball, END)[:, 0].mean() > 0.3


def test_a_flat_lattice_and_a_bspline_one_and_an_open_mesh_simulate():
    for settings in (
        {"resolution": (4, 4, 1)},
        {"resolution": (2, 2, 2)},
        {"resolution": (6, 5, 6), "basis": "BSPLINE"},
    ):
        scenes.empty_file()
        bpy.context.scene.frame_end = 24
        ball = scenes.sphere()
        ball.location.z = 1.5
        bpy.context.view_layer.update()
        bpy.ops.isochor.add(**settings)
        assert simulated() == {"FINISHED"}
        assert -2e-3 < min(world(ball, frame)[:, 2].min() for frame in range(12, 25)) < 2e-3, settings
    scenes.empty_file()
    bpy.context.scene.frame_end = 24
    sheet = scenes.mesh_object("Sheet", [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], [(0, 1, 2, 3)])
    bpy.ops.isochor.add(resolution=(3, 3, 2))
    assert simulated() == {"FINISHED"}
    assert world(sheet, 24)[:, 2].max() < 0.5


def test_gravity_of_the_scene_or_its_own_or_none():
    ball, _lattice = dropped_ball(height=5.0, use_ground=False, use_scene_gravity=False, gravity=(0.0, 0.0, 2.0))
    seconds = (END - 1) / 24.0
    assert world(ball, END)[:, 2].mean() - world(ball, 1)[:, 2].mean() == pytest.approx(seconds**2, abs=0.01)
    bpy.context.scene.use_gravity = False
    assert simulated(use_scene_gravity=True) == {"FINISHED"}
    assert np.abs(world(ball, END) - world(ball, 1)).max() < 1e-4


def test_simulating_again_takes_what_is_left_out_from_the_time_before():
    ball, lattice = dropped_ball(stiffness=4.0, ground_height=-0.5, velocity=(0.0, 1.0, 0.0), frame_end=30)
    first = world(ball, 25)
    assert simulated() == {"FINISHED"}
    assert np.array_equal(world(ball, 25), first)
    assert len(lattice.data.shape_keys.key_blocks) == 30
    assert simulated(stiffness=1.0) == {"FINISHED"}
    assert np.abs(world(ball, 25) - first).max() > 0.05
    scenes.empty_file()
    bpy.context.scene.frame_end = 12
    _ball, lattice = dropped_ball()
    assert len(lattice.data.shape_keys.key_blocks) == END


def test_what_cannot_be_simulated_is_refused_and_nothing_changes():
    assert not bpy.ops.isochor.simulate.poll()
    ball, lattice = dropped_ball()
    data, keys = lattice.data, len(lattice.data.shape_keys.key_blocks)
    scene = bpy.context.scene
    scene.frame_set(7)
    assert "from frame 20 to 20" in refusal(frame_start=20, frame_end=20)
    assert "no object “Floor”" in refusal(ground_object="Floor")
    assert "no vertex group “Hold”" in refusal(pinned="Hold")
    assert lattice.data == data
    assert len(lattice.data.shape_keys.key_blocks) == keys
    assert scene.frame_current == 7
    scenes.set_input(ball.modifiers.active, "Lattice", None)
    assert "Lattice input" in refusal()


def test_edit_mode_is_refused():
    ball, lattice = dropped_ball()
    scenes.choose(lattice)
    assert bpy.ops.isochor.simulate.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.isochor.simulate.poll()
    assert not bpy.ops.isochor.free_simulation.poll()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert ball is not None


def test_linked_lattices_are_refused(tmp_path):
    dropped_ball()
    place = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    with bpy.data.libraries.load(place, link=True) as (_there, here):
        here.objects = ["Ball", "Ball Lattice"]
    for obj in here.objects:
        bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = bpy.data.objects["Ball"]
    bpy.context.view_layer.update()
    assert "another file" in refusal()
    with pytest.raises(RuntimeError, match="another file"):
        bpy.ops.isochor.free_simulation()


def test_several_selected_are_simulated_at_once_each_with_its_own_volume():
    balls = [scenes.sphere(name=name) for name in ("One", "Two")]
    for number, ball in enumerate(balls):
        ball.location = (3.0 * number, 0.0, 1.5)
        bpy.context.view_layer.update()
        scenes.choose(ball)
        bpy.ops.isochor.add()
    bpy.context.scene.frame_end = 20
    balls[0].select_set(True)
    assert simulated() == {"FINISHED"}
    bpy.context.scene.frame_set(20)
    first, second = (scenes.evaluated_positions(ball) for ball in balls)
    assert np.abs(first - second).max() < 1e-4
    assert all(scenes.evaluated_volume(ball) == pytest.approx(scenes.volume(ball.data), rel=1e-6) for ball in balls)
    assert first[:, 2].min() == pytest.approx(-1.5, abs=2e-3)
    assert first[:, 2].max() < 0.6


def test_removing_the_modifier_leaves_nothing_of_the_simulation():
    ball, _lattice = dropped_ball()
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not bpy.data.lattices
    assert not bpy.data.actions
    assert not ball.modifiers


def test_everything_is_explained():
    for name in ("simulate", "free_simulation"):
        operator = getattr(bpy.ops.isochor, name).get_rna_type()
        assert operator.description
        assert all(prop.description for prop in operator.properties if prop.identifier != "rna_type")
    assert hasattr(bpy.types, "VIEW3D_PT_isochor_physics")
