# SPDX-License-Identifier: GPL-3.0-or-later
"""The Flamenco job type: its settings are ones Flamenco has, and it compiles to the tasks that a job needs."""

import ast

import flamenco_manager
import pytest
from flamenco_manager import Refused
from places import FARM, options

SETTINGS = {
    "frames": "1-5",
    "bake_chunk_size": 2,
    "chunk_size": 3,
    "bake_path": "/shared/a shot/isochor",
    "render_output_path": "/shared/a shot/{timestamp}/######",
    "render_output_root": "/shared",
    "blendfile": "/shared/jobs/a shot/ball.flamenco.blend",
    "format": "PNG",
    "scene": "Scene 1",
}
# Flamenco's OpenAPI schemas AvailableJobType and AvailableJobSetting.
TYPES = {"string": str, "int32": int, "float": float, "bool": bool}
SUBTYPES = {"file_path", "dir_path", "file_name", "hashed_file_path"}
VISIBLE = {"visible", "hidden", "submission", "web"}
KEYS = {
    "key", "type", "subtype", "choices", "propargs", "description", "label", "default", "eval", "evalInfo", "visible",
    "required", "editable",
}  # fmt: skip
EVAL_NAMES = {"jobname", "settings", "bpy", "C", "Path", "abspath", "last_n_dir_parts", "str"}


@pytest.fixture(scope="module")
def script():
    return flamenco_manager.Script(FARM / "flamenco" / "isochor_bake_and_render.js")


@pytest.fixture(scope="module")
def declared(script):
    return script.job_type()["settings"]


def compiled(script, **changed):
    return script.compiled(**SETTINGS | changed)


def arguments(job, name):
    """The words of the task's only command behind Blender's own."""
    (command,) = job.task(name)["commands"]
    words = flamenco_manager.argv(command, {"blender": "BLENDER", "blenderArgs": "-b -y"})
    assert words[:3] == ["BLENDER", "-b", "-y"]
    return words[3:]


def test_job_type_has_what_flamenco_shows(script):
    job_type = script.job_type()
    assert job_type.keys() == {"label", "description", "settings"}
    assert job_type["label"]
    assert job_type["description"]


def test_settings_are_of_flamenco_s_kinds(declared):
    assert len({setting["key"] for setting in declared}) == len(declared)
    for setting in declared:
        assert setting.keys() <= KEYS, setting
        assert setting["key"].isidentifier(), setting
        assert setting["description"], setting
        assert setting.get("visible", "visible") in VISIBLE
        if "subtype" in setting:
            assert setting["type"] == "string"
            assert setting["subtype"] in SUBTYPES
        if "choices" in setting:
            assert setting["type"] == "string"
            assert setting["default"] in setting["choices"]
        if "default" in setting:
            assert type(setting["default"]) is TYPES[setting["type"]]
        if "evalInfo" in setting:
            assert setting["evalInfo"].keys() == {"showLinkButton", "description"}


def test_expressions_use_what_flamenco_s_addon_gives_them(declared):
    for setting in (setting for setting in declared if "eval" in setting):
        names = {node.id for node in ast.walk(ast.parse(setting["eval"], mode="eval")) if isinstance(node, ast.Name)}
        assert names <= EVAL_NAMES, setting["key"]


def test_settings_without_a_field_have_a_value(declared):
    """What the panel does not show must come from an expression, a default or, for the blend file, the add-on."""
    for setting in declared:
        if setting.get("visible", "visible") in {"hidden", "web"}:
            assert "eval" in setting or "default" in setting or setting["key"] == "blendfile", setting["key"]


def test_a_job_bakes_joins_and_then_renders(script):
    job = compiled(script)
    names = [task["name"] for task in job.tasks]
    assert names == ["bake-1-2", "bake-3-4", "bake-5-5", "join", "report", "render-1-3", "render-4,5"]
    assert {task["type"] for task in job.tasks} == {"blender"}
    depends = {task["name"]: {names[i] for i in task["dependencies"]} for task in job.tasks}
    assert depends == {
        "bake-1-2": set(), "bake-3-4": set(), "bake-5-5": set(), "join": {"bake-1-2", "bake-3-4", "bake-5-5"},
        "report": set(), "render-1-3": {"join"}, "render-4,5": {"join"},
    }  # fmt: skip


def test_bake_command(script):
    words = arguments(compiled(script, objects="Ball 'Big Nose' \"D'Arcy\" -x", samples=4), "bake-3-4")
    assert words[:4] == ["--command", "isochor", "bake", SETTINGS["blendfile"]]
    assert options(words[4:]) == {
        "--frames": ["3-4"], "--part-of": ["1-5"], "--resume": [""], "--format": ["pc2"], "--samples": ["4"],
        "--object": ["Ball", "Big Nose", "D'Arcy", "-x"], "--output": [SETTINGS["bake_path"]],
    }  # fmt: skip


def test_join_and_report_commands(script):
    job = compiled(script, objects="Ball Nose", samples=4, cache_format="mdd", allow_problems=True)
    objects = {"--object": ["Ball", "Nose"], "--output": [SETTINGS["bake_path"]], "--frames": ["1-5"]}
    join, report = arguments(job, "join"), arguments(job, "report")
    assert join[2:4] == ["join", SETTINGS["blendfile"]]
    assert report[2:4] == ["report", SETTINGS["blendfile"]]
    saved = {"--save": ["/shared/a shot/isochor/ball-baked.blend"], "--format": ["mdd"], "--samples": ["4"]}
    assert options(join[4:]) == objects | saved
    assert options(report[4:]) == objects | {"--allow-problems": [""]}


def test_choices_of_the_artist(script):
    job = compiled(script, cache_format="mdd", resume=False, report=False, render=False, allow_problems=True)
    assert not job.names("render")
    assert not job.names("report")
    found = options(arguments(job, "bake-1-2")[4:])
    assert found["--format"] == ["mdd"]
    assert found["--allow-problems"] == [""]
    assert "--resume" not in found
    assert "--object" not in found


def test_render_command_and_steps(script):
    job = compiled(script)
    words = arguments(job, "render-4,5")
    assert words[0] == options(arguments(job, "join")[4:])["--save"][0] == "/shared/a shot/isochor/ball-baked.blend"
    assert words[words.index("--scene") + 1] == "Scene 1"
    assert words[words.index("--render-frame") + 1] == "4,5"
    assert words[words.index("--render-output") + 1] == "/shared/a shot/2026-01-31_235959/######"
    assert words.index("--render-output") < words.index("--render-frame"), "Blender obeys its arguments in order"
    assert arguments(job, "render-1-3")[-1] == "1..3"
    assert job.task("render-1-3")["commands"][0]["totalStepCount"] == 3
    assert job.settings["render_output_path"] == "/shared/a shot/2026-01-31_235959/######"


def test_gaps_in_the_frames_are_baked_but_not_rendered(script):
    job = compiled(script, frames="2, 5-6, 9", bake_chunk_size=5)
    assert job.names("bake") == ["bake-2-6", "bake-7-9"]
    assert job.names("render") == ["render-2,5,6", "render-9"]
    assert options(arguments(job, "join")[4:])["--frames"] == ["2-9"]


def test_one_frame(script):
    job = compiled(script, frames="7")
    assert job.names("bake") == ["bake-7-7"]
    assert job.names("render") == ["render-7"]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"format": "FFMPEG"}, "image format"),
        ({"frames": "  "}, "frame|range|literal"),
        ({"frames": "one"}, "one"),
        ({"bake_chunk_size": 0}, "chunk size"),
        ({"objects": "'Ball"}, "quotation"),
        ({"render_output_path": ""}, "render_output_path"),
    ],
)
def test_refused_when_submitted(script, wrong, told):
    with pytest.raises(Refused, match=told):
        compiled(script, **wrong)


def test_a_video_format_is_no_matter_where_nothing_is_rendered(script):
    assert compiled(script, format="FFMPEG", render=False).names("bake")
