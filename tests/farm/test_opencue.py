# SPDX-License-Identifier: GPL-3.0-or-later
"""The OpenCue outline: pyoutline makes of it the layers, chunks and dependencies that the job needs."""

import shlex
from pathlib import Path

import cuebot
import pytest
from places import options

WORDS = [
    "/shared/a shot/ball 1.blend", "--frames", "1-5", "--output", "/shared/a shot/isochor", "--bake-chunk", "2",
    "--render-output", "/shared/a shot/frame_####", "--render-chunk", "3", "--show", "film", "--shot", "010",
]  # fmt: skip


@pytest.fixture
def spec(tmp_path):
    return lambda *more: cuebot.Spec(cuebot.printed([*WORDS, *more], tmp_path))


def test_layers_chunks_and_dependencies(spec):
    job = spec()
    assert job.name == "isochor_ball_1"
    assert {layer.name: (layer.range, layer.chunk) for layer in job.layers} == {
        "bake": ("1-5", 2), "join": ("1", 1), "report": ("1", 1), "render": ("1-5", 3),
    }  # fmt: skip
    assert job.depends == {("join", "bake"), ("render", "join")}
    names = [task.name for task in job.tasks()]
    assert names == [
        "0001-bake", "0003-bake", "0005-bake", "0001-join", "0001-report", "0001-render", "0004-render",
    ]  # fmt: skip


def test_order_of_elements_is_the_specification_s(spec):
    """Cuebot validates against its DTD, where the order counts."""
    root = spec().root
    assert [child.tag for child in root] == ["facility", "show", "shot", "user", "email", "uid", "job", "depends"]
    for layer in root.iter("layer"):
        assert layer.get("type") in {"Render", "Util", "Post"}
        assert [child.tag for child in layer] == ["cmd", "range", "chunk", "env", "services", "outputs"]


def commands(job):
    """The words of each task's command as the host's shell splits them."""
    return {task.name: shlex.split(task.commands[0][-1]) for task in job.tasks()}


def test_words_of_the_commands(spec):
    found = commands(spec("--object", "D'Arcy $1", "--object=-B", "--samples", "4"))
    start = ["blender", "--background", "--command", "isochor"]
    caches = {"--format": ["pc2"], "--samples": ["4"], "--object": ["D'Arcy $1", "-B"], "--output": [WORDS[4]]}
    saved = "/shared/a shot/isochor/ball 1-baked.blend"
    assert found["0005-bake"][:6] == [*start, "bake", WORDS[0]]
    assert found["0001-join"][:6] == [*start, "join", WORDS[0]]
    assert options(found["0005-bake"][6:]) == caches | {"--frames": ["5-5"], "--part-of": ["1-5"], "--resume": [""]}
    assert options(found["0001-join"][6:]) == caches | {"--frames": ["1-5"], "--save": [saved]}
    assert found["0001-report"][:6] == [*start, "report", WORDS[0]]
    assert found["0004-render"][3] == saved
    assert found["0004-render"][-5:] == ["-s", "4", "-e", "5", "-a"]
    assert "use_overwrite = True" in " ".join(found["0004-render"])


def test_choices(spec):
    words = ["--no-report", "--no-resume", "--keep-frames", "--format", "mdd", "--allow-problems"]
    found = commands(spec(*words, "--blender", "/opt/my blender/blender"))
    assert not [name for name in found if "report" in name]
    assert {words[0] for words in found.values()} == {"/opt/my blender/blender"}
    bake = options(found["0001-bake"][6:])
    assert bake["--format"] == ["mdd"]
    assert bake["--allow-problems"] == [""]
    assert "--resume" not in bake
    assert "use_overwrite = False" in " ".join(found["0001-render"])


def test_relative_paths_are_made_whole(spec):
    bake = commands(spec("--output", "isochor"))["0001-bake"]
    assert options(bake[6:])["--output"] == [str(Path("isochor").absolute())]


def test_submitted_over_cuebot_s_protocol(spec, tmp_path):
    with cuebot.listening() as (server, taken):
        status, output = cuebot.ran_submitter([*WORDS, "--pause", "--name", "night 1"], tmp_path, server)
    assert status == 0
    assert output.splitlines()[-1] == "film-010-somebody_night_1"
    (sent,) = map(cuebot.Spec, taken)
    assert [task.commands for task in sent.tasks()] == [task.commands for task in spec().tasks()]
    assert sent.root.findtext("job/paused") == "True"
    assert [sent.root.findtext(tag) for tag in ("show", "shot")] == ["film", "010"]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (["--frames", "5-1"], "5-1"),
        (["--frames", "a"], "'a'"),
        (["--bake-chunk", "0"], "'0'"),
        (["--format", "abc"], "abc"),
    ],
)
def test_refused(tmp_path, wrong, told):
    status, output = cuebot.ran_submitter([*WORDS, *wrong, "--print"], tmp_path)
    assert status == 2
    assert told in output
