# SPDX-License-Identifier: GPL-3.0-or-later
"""The OpenCue outline: pyoutline makes of it the layers, chunks and dependencies that the job needs."""

import shlex

import cuebot
import pytest

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
    assert job.depends == {("join", "bake"), ("report", "join"), ("render", "join")}
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


def test_words_of_the_commands(spec):
    tasks = {task.name: shlex.split(task.commands[0][-1]) for task in spec("--object", "D'Arcy $1", "--object", "B").tasks()}
    bake = tasks["0005-bake"]
    assert bake[:7] == ["blender", "--background", "--enable-autoexec", "--command", "isochor", "bake", WORDS[0]]
    assert bake[bake.index("--frames") + 1] == "5-5" and bake[bake.index("--part-of") + 1] == "1-5"
    assert [bake[i + 1] for i, word in enumerate(bake) if word == "--object"] == ["D'Arcy $1", "B"]
    assert "--resume" in bake and bake[bake.index("--output") + 1] == WORDS[4]
    join, render = tasks["0001-join"], tasks["0004-render"]
    assert render[3] == join[join.index("--save") + 1] == "/shared/a shot/isochor/ball 1-baked.blend"
    assert render[-5:] == ["-s", "4", "-e", "5", "-a"]
    assert "use_overwrite = True" in render[render.index("--python-expr") + 1]


def test_choices(spec):
    job = spec("--no-report", "--no-resume", "--keep-frames", "--format", "mdd", "--blender", "/opt/my blender/blender")
    tasks = {task.name: shlex.split(task.commands[0][-1]) for task in job.tasks()}
    assert not [name for name in tasks if "report" in name]
    assert all(words[0] == "/opt/my blender/blender" for words in tasks.values())
    assert "--resume" not in tasks["0001-bake"] and "mdd" in tasks["0001-bake"]
    assert "use_overwrite = False" in tasks["0001-render"][tasks["0001-render"].index("--python-expr") + 1]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [(["--frames", "5-1"], "5-1"), (["--frames", "a"], "'a'"), (["--bake-chunk", "0"], "'0'"), (["--format", "abc"], "abc")],
)
def test_refused(tmp_path, wrong, told):
    status, output = cuebot.ran_submitter([*WORDS, *wrong, "--print"], tmp_path)
    assert status == 2 and told in output
