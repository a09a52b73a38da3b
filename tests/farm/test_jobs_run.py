# SPDX-License-Identifier: GPL-3.0-or-later
"""The jobs of all three farms run for real, several tasks at a time: the caches are those of a bake in one go, byte by
byte, and the frames those of a render in one go.
"""

import json

import cuebot
import flamenco_manager
import numpy as np
import open_job
import pytest
from conftest import CAMERA_FRAMES, FRAMES
from PIL import Image
from places import FARM
from running import Task, ran, run_all

CACHES = {"Ball.pc2", "Big Nose.pc2"}


@pytest.fixture
def place(tmp_path):
    """Where a job leaves its results: a folder with a space and a quote."""
    found = tmp_path / "the farm's results"
    found.mkdir()
    return found


@pytest.fixture
def flamenco(blender, shot, place):
    """Makes the tasks of a Flamenco job, with settings changed."""
    script = flamenco_manager.Script(FARM / "flamenco" / "isochor_bake_and_render.js")

    def tasks(**changed):
        settings = {
            "frames": FRAMES, "bake_chunk_size": 2, "chunk_size": 3, "blendfile": str(shot), "format": "PNG",
            "scene": "Scene", "bake_path": str(place / "isochor"), "render_output_root": str(place),
            "render_output_path": str(place / "{timestamp}" / "frame_####"),
        }  # fmt: skip
        job = script.compiled(**settings | changed)
        return flamenco_manager.commands(job, {"blender": blender, "blenderArgs": "-b -y"})

    return tasks


def pixels(folder):
    """(frames, height, width, channels) of the frames in the folder, which must be all there and no others."""
    names = [f"frame_{frame:04d}.png" for frame in CAMERA_FRAMES]
    assert sorted(path.name for path in folder.iterdir()) == names
    return np.stack([np.asarray(Image.open(folder / name)) for name in names])


def assert_same_caches(folder, reference):
    assert {path.name for path in reference.caches.iterdir()} == CACHES
    for name in CACHES:
        assert (folder / name).read_bytes() == (reference.caches / name).read_bytes(), name


def assert_same_frames(folder, reference):
    wanted = pixels(reference.frames)
    assert len(np.unique(wanted.reshape(len(wanted), -1), axis=0)) == len(wanted), "every frame must show another shape"
    np.testing.assert_array_equal(pixels(folder), wanted)


def assert_done(run):
    assert not run.failed()
    assert None not in run.status.values()
    assert run.most_at_once == 2


def test_flamenco_job(flamenco, place, reference):
    run = run_all(flamenco())
    assert_done(run)
    assert_same_caches(place / "isochor", reference)
    assert_same_frames(place / "2026-01-31_235959", reference)
    assert (place / "isochor" / "volume.csv").is_file()
    assert (place / "isochor" / "volume.png").is_file()
    assert "Progress: 100%" in run.output["bake-1-2"]
    assert "openjd_progress: 100" in run.output["bake-1-2"]


def test_opencue_job(blender, shot, place, reference, tmp_path):
    words = [shot, "--frames", FRAMES, "--output", place / "isochor", "--bake-chunk", "2", "--blender", blender]
    spec = cuebot.printed([*words, "--render-output", place / "frames" / "frame_####", "--render-chunk", "3"], tmp_path)
    assert_done(run_all(cuebot.Spec(spec).tasks()))
    assert_same_caches(place / "isochor", reference)
    assert_same_frames(place / "frames", reference)


@pytest.fixture
def open_jd(blender, shot, place):
    """Makes a task that runs one step of the OpenJD job, or one chunk of it, in a session of its own."""
    parameters = {
        "BlendFile": str(shot), "FirstFrame": 1, "LastFrame": 5, "BakeChunkSize": 2, "RenderChunkSize": 3,
        "CacheDir": str(place / "isochor"), "RenderDir": str(place / "frames"), "Blender": str(blender),
    }  # fmt: skip

    def task(step, frames="", after=(), **changed):
        chunk = ["--task-param", f"Frames={frames}"] if frames else ["--no-run-dependencies"]
        words = ["-p", json.dumps(parameters | changed), "--step", step, *chunk]
        return Task(f"{step} {frames}", [[*open_job.TOOL, "run", str(open_job.TEMPLATE), *words]], after)

    return task


@pytest.fixture
def without_extension(tmp_path, monkeypatch):
    """From its call on, Blender is one that does not have the extension; gives its user folder."""

    def switch():
        bare = tmp_path / "user"
        bare.mkdir()
        monkeypatch.setenv("BLENDER_USER_RESOURCES", str(bare))
        return bare

    return switch


def test_openjd_job(open_jd, place, reference, without_extension):
    """The workers that render do not have the extension."""
    bakes = [open_jd("Bake", frames) for frames in ("1-2", "3-4", "5-5")]
    assert_done(run_all([*bakes, open_jd("Join", after=(0, 1, 2)), open_jd("Report")]))
    without_extension()
    assert_done(run_all([open_jd("Render", frames) for frames in ("1-3", "4-5")]))
    assert_same_caches(place / "isochor", reference)
    assert_same_frames(place / "frames", reference)


def test_openjd_brings_the_extension(open_jd, extension, place, without_extension):
    """To a worker whose Blender does not have it."""
    bare = without_extension()
    without, brought = open_jd("Bake", "1-2"), open_jd("Bake", "1-2", Extension=str(extension))
    assert ran(without.commands[0])[0] != 0
    assert ran(brought.commands[0])[0] == 0
    assert len(list((place / "isochor" / "parts").iterdir())) == len(CACHES)
    assert not (bare / "extensions").exists(), "it must be gone with the job"


def test_one_object_alone(flamenco, place, reference):
    run = run_all(flamenco(objects="'Big Nose'", render=False, report=False))
    assert_done(run)
    found = [path.name for path in (place / "isochor").glob("*.pc2")]
    assert found == ["Big Nose.pc2"]
    assert (place / "isochor" / found[0]).read_bytes() == (reference.caches / found[0]).read_bytes()


def test_a_failing_chunk_stops_what_follows(flamenco):
    run = run_all(flamenco(objects="Bell", report=False))
    assert set(run.failed()) == {"bake-1-2", "bake-3-4", "bake-5-5"}
    assert run.status["join"] is None
    assert run.status["render-1-3"] is None
    assert "Bell" in run.output["bake-1-2"]


def test_submitted_again_it_resumes(flamenco, place, reference):
    """A job that lost a worker is submitted again: what is baked stays, what is missing or damaged is made."""
    settings = {"objects": "Ball", "render": False, "report": False}
    bakes = flamenco(**settings)[:3]
    assert_done(run_all(bakes))
    kept, damaged, lost = sorted((place / "isochor" / "parts").iterdir())
    lost.unlink()
    damaged.write_bytes(damaged.read_bytes()[:-100])
    before = kept.stat().st_mtime_ns
    assert_done(run_all(flamenco(**settings)))
    assert kept.stat().st_mtime_ns == before
    assert (place / "isochor" / "Ball.pc2").read_bytes() == (reference.caches / "Ball.pc2").read_bytes()


def test_join_refuses_while_a_part_is_missing(flamenco, place):
    tasks = flamenco(render=False, report=False)
    join = next(task for task in tasks if task.name == "join")
    run = run_all([tasks[0], Task(join.name, join.commands, (0,))])
    assert run.failed() == ["join"]
    assert "3-5" in run.output["join"]
    assert not list((place / "isochor").glob("*.pc2"))
