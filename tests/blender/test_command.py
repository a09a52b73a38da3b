# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: parts made apart give the bytes of one bake in one go; what goes wrong is told and ends with 1."""

import csv
import signal
from pathlib import Path

import bpy
import numpy as np
import playback
import processes
import pytest
import scenes

FRAMES = 10


@pytest.fixture
def film(tmp_path: Path) -> Path:
    """A saved file with two balls, each squashed by a keyed lattice of its own. One lattice drifts, by less than a
    rounding from frame to frame; the other ball moves with its lattice, at odd angles, so that transforms are rounded
    anew in every frame."""
    for name in ("Ball", "Other"):
        ball = scenes.sphere(16, 10, name=name)
        lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
        scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    drifting = bpy.data.objects["Lattice"]
    for frame, place in ((1, 0.0), (FRAMES, 2e-6)):
        drifting.location.z = place
        drifting.keyframe_insert("location", frame=frame)
    mover = scenes.linked(bpy.data.objects.new("Mover", None))
    for frame, angle in ((1, 0.1), (FRAMES, 1.7)):
        mover.rotation_euler = (angle, 0.3 * angle, 0.7)
        mover.location = (10.1 * angle, 3.3, -7.7)
        mover.keyframe_insert("rotation_euler", frame=frame)
        mover.keyframe_insert("location", frame=frame)
    ball.parent = lattice.parent = mover
    return saved(tmp_path / "film.blend")


def saved(place: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    return place


def command(*words: object) -> int:
    """The handler itself, in this process."""
    return scenes.part("tool.command_line").run([str(word) for word in words])


def told(capsys: pytest.CaptureFixture[str], *words: object, status: int = 1) -> str:
    """The one line that a failing command prints."""
    capsys.readouterr()
    assert command(*words) == status
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    assert lines[0].startswith("isochor: ")
    return lines[0]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(("kind", "samples"), [("pc2", 1), ("mdd", 2)])
def test_parts_made_at_the_same_time_in_any_order_give_the_bytes_of_one_bake(film, tmp_path, kind, samples):
    whole, parts = tmp_path / "whole", tmp_path / "apart"
    shared = ["--output", parts, "--samples", samples, "--format", kind]
    assert command("bake", film, "--frames", "1-10", "--output", whole, *shared[2:]) == 0
    running = [
        processes.start_command("bake", film, "--frames", chunk, "--part-of", "1-10", *shared)
        for chunk in ("7-10", "1-4", "5-6")
    ]
    for process in running:
        _out, err = process.communicate(timeout=processes.LIMIT_S)
        assert process.returncode == 0, err
    assert names(parts) == ["parts"]
    assert command("join", film, "--frames", "1-10", *shared) == 0
    for name in (f"Ball.{kind}", f"Other.{kind}"):
        assert (whole / name).read_bytes() == (parts / name).read_bytes()
    held = scenes.part("core.point_cache").read(whole / f"Other.{kind}")[1]
    assert len(held) == 9 * samples + 1
    assert np.ptp(held[4 * samples], axis=0)[2] < 0.9 * np.ptp(held[0], axis=0)[2]


def test_a_new_blender_runs_the_command_and_prints_what_farms_read(film, tmp_path):
    done = processes.run_command("bake", film, "--frames", "1-4", "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line for line in lines if line.startswith("openjd_progress: ")] == [
        f"openjd_progress: {percent}" for percent in ("25.0", "50.0", "75.0", "100.0")
    ]
    assert [line for line in lines if line.startswith("Fra:")] == [
        f"Fra:{frame} | Ball, Other | Progress: {25 * frame}%" for frame in (1, 2, 3, 4)
    ]
    assert names(tmp_path / "out") == ["Ball.pc2", "Other.pc2"]
    failed = processes.run_command("bake", film, "--frames", "1-3", "--output", tmp_path / "out", "--object", "Nobody")
    assert failed.returncode == 1
    assert "isochor: There is no object “Nobody”" in failed.stderr
    assert "Traceback" not in failed.stderr


def test_join_saves_a_file_that_plays_without_the_add_on_wherever_it_lies(film, tmp_path):
    out, baked = tmp_path / "out", tmp_path / "elsewhere" / "deep" / "baked.blend"
    before = film.read_bytes()
    for chunk in ("1-5", "6-10"):
        assert command("bake", film, "--frames", chunk, "--part-of", "1-10", "--output", out) == 0
    assert command("join", film, "--frames", "1-10", "--output", out, "--save", baked) == 0
    assert film.read_bytes() == before
    bpy.ops.wm.open_mainfile(filepath=str(baked))
    for name in ("Ball", "Other"):
        volume_lattice, cache = bpy.data.objects[name].modifiers
        assert cache.filepath == f"//../../out/{name}.pc2"
        assert not volume_lattice.show_render
        assert not volume_lattice.show_viewport
    moved = tmp_path / "moved"
    moved.mkdir()
    (tmp_path / "elsewhere").rename(moved / "elsewhere")
    out.rename(moved / "out")
    played = playback.without_the_add_on(moved / "elsewhere" / "deep" / "baked.blend", "Ball", list(range(1, 11)))
    assert np.array_equal(played, scenes.part("core.point_cache").read(moved / "out" / "Ball.pc2")[1])
    assert np.ptp(played[4], axis=0)[2] < 0.8 * np.ptp(played[0], axis=0)[2]


def test_join_names_what_is_missing_damaged_or_outdated(film, tmp_path, capsys):
    out = tmp_path / "out"
    whole = ["--frames", "1-10", "--output", out]
    assert "lacks frames 1-10 of 1-10" in told(capsys, "join", film, *whole)
    for chunk in ("1-3", "5-6", "8-10"):
        assert command("bake", film, "--frames", chunk, "--part-of", "1-10", "--output", out) == 0
    assert "“Ball” lacks frames 4, 7 of 1-10" in told(capsys, "join", film, *whole)
    part = out / "parts" / "Ball.1-10.5-6.part"
    data = bytearray(part.read_bytes())
    data[-100] ^= 1
    part.write_bytes(data)
    text = told(capsys, "join", film, *whole, "--object", "Ball")
    assert "lacks frames 4-7" in text
    assert "Damaged: Ball.1-10.5-6.part." in text
    bpy.context.scene.frame_end += 1
    saved(film)
    text = told(capsys, "join", film, *whole, "--object", "Ball")
    assert "lacks frames 1-10" in text
    assert "another version of the .blend: Ball.1-10.1-3.part" in text
    assert names(out) == ["parts"]


def test_parts_are_outdated_once_a_linked_library_has_changed(film, tmp_path, capsys):
    scenes.empty_file()
    with bpy.data.libraries.load(str(film), link=True, relative=True) as (_found, wanted):
        wanted.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    wanted.objects[0].override_create(remap_local_usages=True)
    shot, out = saved(tmp_path / "shot.blend"), tmp_path / "out"
    part = ["bake", shot, "--frames", "1-2", "--part-of", "1-2", "--output", out]
    assert command(*part) == 0
    assert command("join", shot, "--frames", "1-2", "--output", out) == 0
    bpy.ops.wm.open_mainfile(filepath=str(film))
    bpy.context.scene.frame_end += 1
    saved(film)
    assert "another version of the .blend" in told(capsys, "join", shot, "--frames", "1-2", "--output", out)


def test_resume_makes_only_what_is_not_there_and_sound(film, tmp_path):
    out, whole = tmp_path / "out", tmp_path / "whole"
    assert command("bake", film, "--frames", "1-10", "--output", whole) == 0
    chunk = ["--frames", "4-6", "--part-of", "1-10", "--output", out, "--resume"]
    assert command("bake", film, *chunk) == 0
    made = {name: (out / "parts" / name).stat().st_mtime_ns for name in names(out / "parts")}
    damaged = out / "parts" / "Other.1-10.4-6.part"
    damaged.write_bytes(damaged.read_bytes()[:-1])
    assert command("bake", film, *chunk) == 0
    again = {name: (out / "parts" / name).stat().st_mtime_ns for name in names(out / "parts")}
    assert again["Ball.1-10.4-6.part"] == made["Ball.1-10.4-6.part"]
    assert again["Other.1-10.4-6.part"] != made["Other.1-10.4-6.part"]
    assert command("bake", film, "--frames", "1-10", "--output", out, "--resume") == 0
    for name in ("Ball.pc2", "Other.pc2"):
        assert (whole / name).read_bytes() == (out / name).read_bytes()


def test_join_takes_the_objects_that_were_baked(film, tmp_path):
    out = tmp_path / "out"
    assert command("bake", film, "--frames", "1-2", "--part-of", "1-2", "--output", out, "--object", "Other") == 0
    assert command("join", film, "--frames", "1-2", "--output", out) == 0
    assert names(out) == ["Other.pc2", "parts"]


@pytest.mark.parametrize("part_of", [[], ["--part-of", "1-100000"]])
def test_a_bake_that_is_killed_leaves_no_file_under_a_final_name(film, tmp_path, part_of):
    out = tmp_path / "out"
    (out / "parts").mkdir(parents=True)
    (out / "Ball.pc2").write_bytes(b"from before")
    process = processes.start_command("bake", film, "--frames", "1-100000", *part_of, "--output", out)
    for line in process.stdout:
        if line.startswith("Fra:5 "):
            break
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=processes.LIMIT_S)
    assert process.returncode == -signal.SIGKILL
    found = [path for path in out.rglob("*") if path.is_file()]
    unfinished = [path for path in found if path.name.startswith(".") and path.name.endswith(".unfinished")]
    assert len(unfinished) == 2
    assert [path.name for path in found if path not in unfinished] == ["Ball.pc2"]
    assert (out / "Ball.pc2").read_bytes() == b"from before"


def test_report_measures_the_volume_of_every_frame(film, tmp_path, capsys):
    out = tmp_path / "out"
    assert command("report", film, "--frames", "1-10", "--output", out) == 0
    rows = list(csv.DictReader((out / "volume.csv").open()))
    assert [(row["frame"], row["object"]) for row in rows] == [
        (str(frame), name) for frame in range(1, 11) for name in ("Ball", "Other")
    ]
    assert command("bake", film, "--frames", "1-10", "--output", out) == 0
    held = scenes.part("core.point_cache").read(out / "Ball.pc2")[1]
    ball = bpy.data.objects["Ball"]
    for row, shape in zip(rows[::2], held):
        assert abs(float(row["relative_error"])) < 1e-6
        mesh = ball.data.copy()
        mesh.attributes["position"].data.foreach_set("vector", shape.reshape(-1))
        assert float(row["after"]) == pytest.approx(scenes.volume(mesh), rel=1e-12)
        assert float(row["target"]) == pytest.approx(scenes.volume(ball.data), rel=1e-9)
    assert float(rows[8]["before"]) < 0.6 * float(rows[8]["target"])
    curve = bpy.data.images.load(str(out / "volume.png"))
    assert tuple(curve.size) == (800, 2 * 400)
    assert len(np.unique(np.array(curve.pixels).reshape(-1, 4), axis=0)) > 5
    capsys.readouterr()
    assert command("report", film, "--frames", "5", "--object", "Ball") == 0
    printed = capsys.readouterr().out
    assert printed[printed.index("frame,") :].splitlines()[1].startswith("5,Ball,")


def test_problems_of_the_modifier_fail_unless_they_are_allowed(tmp_path, capsys):
    points, faces = scenes.sphere_arrays(16, 10)
    ball = scenes.mesh_object("Ball", points, faces[:-1])
    scenes.volume_lattice(ball, scenes.squashing_lattice(ball, 6, frames=FRAMES), Basis="B-Spline")
    film, out = saved(tmp_path / "open.blend"), tmp_path / "out"
    bake = ["bake", film, "--frames", "2-4", "--output", out]
    for words in (bake, [*bake, "--part-of", "1-10"]):
        text = told(capsys, *words)
        assert "Nothing was written. Ball, 3 frames from 2 to 4: " in text
        assert "hole" in text
        assert not [path for path in out.rglob("*") if path.is_file()]
    assert command(*bake, "--allow-problems") == 0
    assert names(out / "parts") == []
    assert (out / "Ball.pc2").is_file()
    report = ["report", film, "--frames", "2-4", "--output", out]
    assert "Ball, 3 frames from 2 to 4: " in told(capsys, *report)
    assert command(*report, "--allow-problems") == 0
    assert "\n2,Ball,,," in (out / "volume.csv").read_text()


def test_what_is_wrong_is_told_in_one_line(film, tmp_path, capsys):
    out = ["--output", tmp_path / "out"]
    frames = ["--frames", "1-10"]
    bpy.ops.wm.open_mainfile(filepath=str(film))
    scenes.sphere(name="Bare")
    saved(film)
    assert "“Bare” has no Volume Lattice" in told(capsys, "bake", film, *frames, *out, "--object", "Bare")
    assert "There is no object “Nobody”" in told(capsys, "report", film, *frames, "--object", "Nobody")
    assert "“Mover” is not a mesh but of type empty" in told(capsys, "bake", film, *frames, *out, "--object", "Mover")
    assert "is not there" in told(capsys, "bake", tmp_path / "none.blend", *frames, *out)
    broken = tmp_path / "broken.blend"
    broken.write_text("no blend")
    assert "cannot be opened" in told(capsys, "bake", broken, *frames, *out)
    assert "ends before it begins" in told(capsys, "bake", film, "--frames", "5-1", *out)
    assert "is no range of frames" in told(capsys, "bake", film, "--frames", "one", *out)
    assert "is no part of 2-5" in told(capsys, "bake", film, *frames, "--part-of", "2-5", *out)
    assert "--save names the file itself" in told(capsys, "join", film, *frames, *out, "--save", film)
    assert "cannot be written" in told(capsys, "bake", film, *frames, "--output", broken)
    assert "required: COMMAND" in told(capsys, status=2)
    assert "required: --output" in told(capsys, "bake", film, *frames, status=2)
    assert "invalid choice" in told(capsys, "bake", film, *frames, *out, "--format", "abc", status=2)
    assert "from 1 to 100" in told(capsys, "bake", film, *frames, *out, "--samples", "0", status=2)
    scenes.empty_file()
    nothing = saved(tmp_path / "empty.blend")
    assert "No object of the scene has a Volume Lattice" in told(capsys, "bake", nothing, *frames, *out)
    assert not (tmp_path / "out").exists()


def test_negative_frames_and_help(film, tmp_path, capsys):
    assert command("bake", film, "--frames=-2-1", "--output", tmp_path) == 0
    assert scenes.part("core.point_cache").read(tmp_path / "Ball.pc2")[0].first_frame == -2
    capsys.readouterr()
    assert command("bake", "--help") == 0
    assert "--part-of FIRST-LAST" in capsys.readouterr().out
