# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to point caches: what plays afterwards, without the add-on, is what was seen before."""

import gc
import weakref
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import playback
import pytest
import scenes
from numpy.typing import NDArray

FRAMES = 8
ALL = list(range(1, FRAMES + 1))
HALVES = [1.5, 4.5, 7.25]


def bouncing(name: str = "Ball") -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A ball that moves, whose lattice, keyed over the frames, squashes and shears it."""
    ball = scenes.sphere(16, 10, name=name)
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    modifier = scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    for frame, angle in ((1, 0.0), (FRAMES, 0.4)):
        ball.rotation_euler.y = angle
        ball.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.context.scene.frame_set(1)
    return ball, modifier


def shapes(obj: bpy.types.Object, frames: list[float]) -> NDArray[np.float64]:
    """(F, V, 3) what Blender draws of the object in these frames."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
        found.append(scenes.evaluated_positions(obj))
    return np.array(found)


def cached(path: Path) -> NDArray[np.float32]:
    """(S, V, 3) what the file holds."""
    return np.array(scenes.part("core.point_cache").read(path)[1])


def saved(tmp_path: Path) -> Path:
    place = tmp_path / "film.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    return place


def bake(obj: bpy.types.Object, **properties) -> set[str]:
    scenes.choose(obj)
    return bpy.ops.isochor.bake(**properties)


def refusal(**properties) -> str:
    with pytest.raises(RuntimeError) as found:
        bpy.ops.isochor.bake(**properties)
    return str(found.value)


def off(modifier: bpy.types.Modifier) -> bool:
    return not modifier.show_viewport and not modifier.show_render


@pytest.mark.parametrize("kind", ["PC2", "MDD"])
def test_a_bake_plays_in_a_blender_without_the_add_on_what_was_seen_before(tmp_path, kind):
    ball, modifier = bouncing()
    place = saved(tmp_path)
    seen = shapes(ball, ALL)
    assert np.ptp(seen[3], axis=0)[2] < 0.8 * np.ptp(seen[0], axis=0)[2]
    assert bake(ball, format=kind) == {"FINISHED"}
    assert [found.type for found in ball.modifiers] == ["NODES", "MESH_CACHE"]
    assert off(modifier)
    assert ball.modifiers[1].filepath.startswith("//")
    file = tmp_path / "isochor_cache" / "film" / f"Ball.{kind.lower()}"
    bpy.ops.wm.save_mainfile()
    played = playback.without_the_add_on(place, "Ball", [*ALL, *HALVES])
    held = cached(file)
    assert np.array_equal(played[:FRAMES], held)
    assert np.abs(held - seen).max() < 1e-6
    for frame, shape in zip(HALVES, played[FRAMES:]):
        before, share = int(frame) - 1, frame % 1
        assert np.abs(shape - ((1 - share) * held[before] + share * held[before + 1])).max() < 1e-6


def test_samples_between_frames_are_what_was_seen_there(tmp_path):
    ball, _ = bouncing()
    place = saved(tmp_path)
    frames = [3, 3.25, 3.5, 3.75, 4]
    seen = shapes(ball, frames)
    assert bake(ball, format="PC2", frame_start=3, frame_end=4, samples=4) == {"FINISHED"}
    bpy.ops.wm.save_mainfile()
    assert np.abs(playback.without_the_add_on(place, "Ball", frames) - seen).max() < 1e-6
    assert np.abs(seen[1] - (0.75 * seen[0] + 0.25 * seen[4])).max() > 1e-4


def test_stretched_time_plays_what_was_seen(tmp_path):
    ball, _ = bouncing()
    place = saved(tmp_path)
    bpy.context.scene.render.frame_map_old, bpy.context.scene.render.frame_map_new = 100, 230
    seen = shapes(ball, ALL)
    assert bake(ball, format="PC2") == {"FINISHED"}
    bpy.ops.wm.save_mainfile()
    assert np.abs(playback.without_the_add_on(place, "Ball", ALL) - seen).max() < 1e-5
    assert "take fewer samples" in refusal(format="PC2", samples=90)


def test_the_frame_and_everything_else_is_put_back(tmp_path):
    ball, modifier = bouncing()
    subdivision = ball.modifiers.new("Subdivision", "SUBSURF")
    bpy.context.scene.frame_set(5, subframe=0.25)
    assert bake(ball, format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    assert bpy.context.scene.frame_current == 5
    assert bpy.context.scene.frame_subframe == 0.25
    assert subdivision.show_viewport
    assert [found.name for found in ball.modifiers] == [modifier.name, "Volume Lattice Cache", "Subdivision"]
    assert cached(tmp_path / "Ball.pc2").shape[1] == len(ball.data.vertices)


def test_several_objects_in_one_go_and_names_that_files_cannot_have(tmp_path):
    names = ["Ball", "ball", "a/b:c?", "CON"]
    balls = [bouncing(name)[0] for name in names]
    walked = []
    bpy.app.handlers.frame_change_post.append(lambda scene: walked.append(scene.frame_current))
    for ball in balls:
        ball.select_set(True)
    assert bpy.ops.isochor.bake(format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    bpy.app.handlers.frame_change_post.pop()
    assert walked == [*ALL, 1]
    files = [Path(ball.modifiers[-1].filepath) for ball in balls]
    assert len({file.name.lower() for file in files}) == 4
    assert all(file.parent == tmp_path and file.is_file() for file in files)
    for ball, file in zip(balls, files):
        assert np.array_equal(shapes(ball, ALL), cached(file))


def test_a_chain_is_baked_as_a_whole_behind_what_comes_before(tmp_path):
    ball, first = bouncing()
    cast = ball.modifiers.new("Cast", "CAST")
    cast.factor = 0.3
    ball.modifiers.move(1, 0)
    second = scenes.volume_lattice(ball, scenes.lattice_object(3, name="Second", size=3.0))
    for point in bpy.data.objects["Second"].data.points:
        point.co_deform.x *= 1.3
    ball.modifiers.new("Subdivision", "SUBSURF")
    place = saved(tmp_path)
    seen = shapes(ball, ALL)
    assert bake(ball, format="MDD") == {"FINISHED"}
    assert [found.type for found in ball.modifiers] == ["CAST", "NODES", "NODES", "MESH_CACHE", "SUBSURF"]
    assert off(first)
    assert off(second)
    bpy.ops.wm.save_mainfile()
    assert np.abs(playback.without_the_add_on(place, "Ball", ALL) - seen).max() < 2e-6


def test_baking_again_replaces_and_freeing_brings_ours_back(tmp_path):
    ball, modifier = bouncing()
    seen = shapes(ball, ALL)
    assert bake(ball, format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    first = (tmp_path / "Ball.pc2").read_bytes()
    cache = ball.modifiers[1]
    cache.name, modifier.name = "Renamed", "Too"
    assert bake(ball, format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    assert (tmp_path / "Ball.pc2").read_bytes() == first
    assert [found.name for found in ball.modifiers] == ["Too", "Renamed"]
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert [found.name for found in ball.modifiers] == ["Too"]
    assert modifier.show_viewport
    assert modifier.show_render
    assert "isochor_bake" not in ball
    assert np.abs(shapes(ball, ALL) - seen).max() < 1e-6
    assert (tmp_path / "Ball.pc2").read_bytes() == first
    assert not bpy.ops.isochor.free_bake.poll()


def test_freeing_leaves_off_what_was_off(tmp_path):
    ball, first = bouncing()
    second = scenes.volume_lattice(ball, scenes.lattice_object(2, name="Second", size=3.0))
    first.show_viewport = first.show_render = False
    second.show_viewport = False
    assert bake(ball, format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    assert off(first)
    assert not second.show_viewport
    assert second.show_render


def test_baking_and_freeing_are_one_undo_step_each(tmp_path):
    bouncing()
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.isochor.bake("EXEC_DEFAULT", True, format="PC2", directory=str(tmp_path))
    bpy.ops.ed.undo()
    assert [found.type for found in bpy.data.objects["Ball"].modifiers] == ["NODES"]
    assert bpy.data.objects["Ball"].modifiers[0].show_render
    bpy.ops.ed.redo()
    assert [found.type for found in bpy.data.objects["Ball"].modifiers] == ["NODES", "MESH_CACHE"]
    bpy.ops.isochor.free_bake("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    ball = bpy.data.objects["Ball"]
    assert [found.type for found in ball.modifiers] == ["NODES", "MESH_CACHE"]
    assert off(ball.modifiers[0])


def test_what_a_render_sees_is_baked_where_the_viewport_sees_another_mesh(tmp_path):
    ball, modifier = bouncing()
    subdivision = ball.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 0, 1
    ball.modifiers.move(1, 0)
    place = saved(tmp_path)
    subdivision.levels = 1
    whole = scenes.part("tool.results").of(modifier, "RENDER")["isochor_rest_volume"]
    scenes.part("tool.results").of(modifier, "VIEWPORT")["isochor_rest_volume"] = whole
    wanted = shapes(ball, ALL)
    bpy.ops.wm.open_mainfile(filepath=str(place))
    ball = bpy.data.objects["Ball"]
    shown = shapes(ball, ALL)
    assert bake(ball, format="PC2") == {"FINISHED"}
    held = cached(tmp_path / "isochor_cache" / "film" / "Ball.pc2")
    assert held.shape == wanted.shape
    assert np.abs(held - wanted).max() < 1e-6
    subdivision, modifier, cache = ball.modifiers
    assert (subdivision.levels, subdivision.render_levels) == (0, 1)
    assert (modifier.show_viewport, modifier.show_render) == (True, False)
    assert (cache.show_viewport, cache.show_render) == (False, True)
    assert np.abs(shapes(ball, ALL) - shown).max() < 1e-6


def test_changing_vertex_counts_are_refused_and_nothing_is_left_behind(tmp_path):
    ball, modifier = bouncing()
    decimate = ball.modifiers.new("Array", "ARRAY")
    ball.modifiers.move(1, 0)
    for frame, count in ((1, 1), (5, 1), (6, 2)):
        decimate.count = count
        decimate.keyframe_insert("count", frame=frame)
    scenes.set_input(modifier, "Preserve", 0.0)
    (tmp_path / "Ball.pc2").write_bytes(b"from before")
    bpy.context.scene.frame_set(2)
    text = refusal(format="PC2", directory=str(tmp_path))
    count = len(ball.data.vertices)
    assert f"“Ball” has {count} vertices in frame 1 and {2 * count} in frame 6" in text
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("Ball.pc2", b"from before")]
    assert [found.type for found in ball.modifiers] == ["ARRAY", "NODES"]
    assert modifier.show_viewport
    assert bpy.context.scene.frame_current == 2


def test_closing_a_bake_before_its_end_leaves_nothing_behind(tmp_path):
    ball, modifier = bouncing()
    frames, files = scenes.part("tool.frames"), scenes.part("tool.bake_file")
    (tmp_path / "Ball.pc2").write_bytes(b"from before")
    bpy.context.scene.frame_set(3)
    running = files.bake(bpy.context, frames.targets([ball]), [tmp_path / "Ball.pc2"], files.Plan("PC2", 1, FRAMES))
    assert [next(running).done for _ in range(4)] == [1, 2, 3, 4]
    assert len(list(tmp_path.iterdir())) == 2
    running.close()
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("Ball.pc2", b"from before")]
    assert bpy.context.scene.frame_current == 3
    assert modifier.show_viewport
    assert len(ball.modifiers) == 1


def test_refusals(tmp_path):
    ball, modifier = bouncing()
    assert "save it, or give a folder" in refusal(format="PC2")
    assert "comes before the first" in refusal(format="PC2", directory=str(tmp_path), frame_start=5, frame_end=4)
    assert "which is not saved yet" in refusal(format="PC2", directory="//caches")
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert "cannot be written" in refusal(format="PC2", directory=str(blocked))
    modifier.show_render = False
    assert "switched off for renders on “Ball”" in refusal(format="PC2", directory=str(tmp_path))
    modifier.show_render = True
    bpy.ops.object.mode_set(mode="EDIT")
    assert "“Ball” is in Edit Mode" in refusal(format="PC2", directory=str(tmp_path))
    bpy.ops.object.mode_set(mode="OBJECT")
    bouncing("Other")
    ball.select_set(True)
    assert "One file is given for 2 objects" in refusal(format="PC2", filepath=str(tmp_path / "one.pc2"))
    scenes.choose(scenes.sphere(name="Bare"))
    assert not bpy.ops.isochor.bake.poll()
    assert not bpy.ops.isochor.free_bake.poll()
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("way", ["screen", "eye"])
def test_what_the_viewport_alone_hides_is_baked_and_stays_hidden(tmp_path, way):
    ball, _ = bouncing()
    seen = shapes(ball, ALL)
    if way == "screen":
        ball.hide_viewport = True
    else:
        ball.hide_set(True)
    assert bpy.ops.isochor.bake(format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    assert ball.hide_viewport == (way == "screen")
    assert ball.hide_get() == (way == "eye")
    assert np.abs(cached(tmp_path / "Ball.pc2") - seen).max() < 1e-6


def test_an_object_hidden_with_its_collection_is_refused(tmp_path):
    ball, _ = bouncing()
    collection = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(ball)
    collection.objects.link(ball)
    bpy.context.view_layer.objects.active = ball
    collection.hide_viewport = True
    assert "“Ball” is hidden with its collection" in refusal(format="PC2", directory=str(tmp_path))
    assert not list(tmp_path.iterdir())
    assert len(ball.modifiers) == 1


def test_linked_objects_are_refused(tmp_path):
    bouncing()
    place = saved(tmp_path)
    scenes.empty_file()
    with bpy.data.libraries.load(str(place), link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    scenes.linked(wanted.objects[0])
    assert "make a library override" in refusal(format="PC2", directory=str(tmp_path))


def test_an_override_plays_its_bake_after_loading(tmp_path):
    bouncing()
    place = saved(tmp_path)
    scenes.empty_file()
    with bpy.data.libraries.load(str(place), link=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    override = wanted.objects[0].override_create(remap_local_usages=True)
    bpy.context.scene.frame_set(1)
    seen = shapes(override, ALL)
    shot = tmp_path / "shot.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(shot))
    assert bake(override, format="PC2", frame_start=1, frame_end=FRAMES) == {"FINISHED"}
    bpy.ops.wm.save_mainfile()
    played = playback.without_the_add_on(shot, override.name, ALL)
    assert np.abs(played - seen).max() < 1e-6


def test_problems_are_told_with_their_frames_and_do_not_stop_the_bake(tmp_path, capfd):
    ball, modifier = bouncing()
    lattice = scenes.get_input(modifier, "Lattice")
    size = lattice.scale.z
    for frame, value in ((4, size), (5, 0.0), (6, 0.0), (7, size)):
        lattice.scale.z = value
        lattice.keyframe_insert("scale", frame=frame)
    bpy.context.scene.frame_set(1)
    capfd.readouterr()
    assert bake(ball, format="PC2", directory=str(tmp_path)) == {"FINISHED"}
    assert "Ball, 2 frames from 5 to 6: The lattice “Lattice” has a scale of zero" in capfd.readouterr().out
    held = cached(tmp_path / "Ball.pc2")
    assert np.array_equal(held[4], scenes.positions(ball.data).astype(np.float32))
    assert not np.array_equal(held[3], held[4])


def test_what_is_forgotten_is_let_go_at_once():
    ball, modifier = bouncing()
    state = scenes.part("tool.state")
    report = scenes.report(ball, modifier)
    solver = weakref.ref(state.recall(ball, modifier).solver)
    assert solver() is not None
    gc.disable()
    try:
        state.forget([ball])
        assert solver() is None
    finally:
        gc.enable()
    assert report.volumes.before == pytest.approx(report.volumes.target, rel=1e-6)


class Window:
    """As much of a window as a running operator uses, and what it showed."""

    def __init__(self) -> None:
        self.window = self.window_manager = self.workspace = self
        self.texts: list[str | None] = []
        self.timers = 0

    def event_timer_add(self, _seconds: float, window: object) -> str:
        assert window is self
        self.timers += 1
        return "timer"

    def event_timer_remove(self, timer: str) -> None:
        assert timer == "timer"
        self.timers -= 1

    def status_text_set(self, text: str | None) -> None:
        self.texts.append(text)

    def progress_begin(self, _low: float, _high: float) -> None: ...

    def progress_update(self, share: float) -> None:
        assert 0.0 <= share <= 1.0

    def progress_end(self) -> None: ...

    def modal_handler_add(self, _operator: object) -> None: ...


def running(obj: bpy.types.Object, path: Path):
    """A bake to PC2 as an operator runs it in a window: the operator and the window."""
    frames, files, stepping = (scenes.part(name) for name in ("tool.frames", "tool.bake_file", "ui.stepping"))
    stepping_operator = type("Operator", (stepping.Stepping,), {"report": lambda self, kind, text: said.append(text)})
    said: list[str] = []
    operator, window = stepping_operator(), Window()
    operator._with_progress = True
    bake = files.bake(bpy.context, frames.targets([obj]), [path], files.Plan("PC2", 1, FRAMES))
    assert operator.run(window, bake) == {"RUNNING_MODAL"}
    return operator, window, said


def test_a_bake_in_a_window_tells_how_far_it_is(tmp_path, monkeypatch):
    ball, _ = bouncing()
    monkeypatch.setattr(scenes.part("ui.stepping"), "PATIENCE_S", 0.0001)
    operator, window, said = running(ball, tmp_path / "Ball.pc2")
    ends = [operator.modal(window, SimpleNamespace(type="TIMER", value="NOTHING")) for _ in range(FRAMES + 1)]
    assert ends == [{"RUNNING_MODAL"}] * FRAMES + [{"FINISHED"}]
    assert window.texts[2].startswith("Baking frame 3: 3 of 8.")
    assert window.texts[-1] is None
    assert window.timers == 0
    assert not said
    assert len(cached(tmp_path / "Ball.pc2")) == FRAMES
    assert len(ball.modifiers) == 2


def test_escape_ends_a_bake_in_a_window_and_leaves_nothing_behind(tmp_path, monkeypatch):
    ball, modifier = bouncing()
    monkeypatch.setattr(scenes.part("ui.stepping"), "PATIENCE_S", 0.0001)
    (tmp_path / "Ball.pc2").write_bytes(b"from before")
    operator, window, said = running(ball, tmp_path / "Ball.pc2")
    for _ in range(3):
        assert operator.modal(window, SimpleNamespace(type="TIMER", value="NOTHING")) == {"RUNNING_MODAL"}
    assert operator.modal(window, SimpleNamespace(type="MOUSEMOVE", value="NOTHING")) == {"RUNNING_MODAL"}
    assert bpy.context.scene.frame_current == 3
    assert operator.modal(window, SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    assert said == ["Bake cancelled: nothing was written"]
    assert window.timers == 0
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("Ball.pc2", b"from before")]
    assert bpy.context.scene.frame_current == 1
    assert modifier.show_viewport
    assert len(ball.modifiers) == 1
