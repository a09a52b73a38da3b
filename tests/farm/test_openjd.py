# SPDX-License-Identifier: GPL-3.0-or-later
"""The Open Job Description template: valid, and its steps run the commands the job needs, whatever the names."""

import open_job
import pytest
from places import options

# Prints its arguments in hexadecimal, whatever is in them, and ends with the status that is filled in.
STAND_IN = """#!/bin/sh
printf CALL
for word; do printf " %s" "$(printf %s "$word" | od -An -v -tx1 | tr -d " \\n")"; done
echo
exit {}
"""
OBJECTS = ["-x", 'D\'Arcy "$HOME"', "{{Big}} Nose\\n", "é #1"]
START = ["--background", "--command", "isochor"]
CACHES = {"--format": ["pc2"], "--samples": ["1"], "--output": ["/shared/a shot/isochor"]}


@pytest.fixture
def job(tmp_path):
    """Runs a step with its dependencies with a stand-in for Blender that prints how it is called."""

    def run(step, status=0, **changed):
        blender = tmp_path / "blender"
        blender.write_text(STAND_IN.format(status))
        blender.chmod(0o755)
        parameters = {
            "BlendFile": "/shared/a shot/ball.blend", "CacheDir": "/shared/a shot/isochor",
            "RenderDir": "/shared/a shot", "FirstFrame": 1, "LastFrame": 5, "BakeChunkSize": 2, "RenderChunkSize": 3,
            "Blender": str(blender),
        } | changed  # fmt: skip
        return open_job.run(step, parameters, tmp_path)

    return run


def calls(output):
    """How the stand-in was called."""
    lines = [line.split("CALL", 1)[1].split() for line in output.splitlines() if "CALL" in line]
    return [[bytes.fromhex(word).decode() for word in line] for line in lines]


def test_template_is_valid():
    status, output = open_job.check()
    assert status == 0, output


def test_summary_has_the_steps_and_their_order(tmp_path):
    summary = open_job.summary({"BlendFile": "/a.blend", "CacheDir": "/c", "RenderDir": "/r"})
    steps = {step["name"]: [on["step_name"] for on in step.get("dependencies", [])] for step in summary["steps"]}
    assert steps == {"Bake": [], "Join": ["Bake"], "Report": [], "Render": ["Join"]}


def test_bake_commands(job):
    status, output = job("Bake", Objects="\n".join(OBJECTS), Samples=4)
    assert status == 0
    found = calls(output)
    assert [words[:5] for words in found] == [[*START, "bake", "/shared/a shot/ball.blend"]] * 3
    rest = {"--part-of": ["1-5"], "--resume": [""]} | CACHES | {"--object": OBJECTS, "--samples": ["4"]}
    assert [options(words[5:]) for words in found] == [
        {"--frames": [frames]} | rest for frames in ("1-2", "3-4", "5-5")
    ]  # fmt: skip


def test_join_and_render_commands(job):
    status, output = job("Render", Objects="Ball")
    assert status == 0
    join, *renders = calls(output)[3:]
    saved = "/shared/a shot/isochor/baked.blend"
    assert join[:5] == [*START, "join", "/shared/a shot/ball.blend"]
    assert options(join[5:]) == CACHES | {"--frames": ["1-5"], "--save": [saved], "--object": ["Ball"]}
    assert [words[-5:] for words in renders] == [["-s", "1", "-e", "3", "-a"], ["-s", "4", "-e", "5", "-a"]]
    for words in renders:
        assert words[:5] == [START[0], "--enable-autoexec", saved, "--render-output", "/shared/a shot/frame_####"]
        assert "use_overwrite = True" in " ".join(words)


def test_frames_before_zero_are_not_rendered_as_others(job):
    """To Blender, -s -3 is the third frame from the end."""
    status, output = job("Render", FirstFrame=-3, LastFrame=-1)
    assert status != 0
    assert not [words for words in calls(output) if "-s" in words]


def test_choices(job):
    bake = options(calls(job("Bake", Resume="false", CacheFormat="mdd", AllowProblems="true")[1])[0][5:])
    assert bake["--format"] == ["mdd"]
    assert bake["--allow-problems"] == [""]
    assert "--resume" not in bake
    assert "--object" not in bake
    assert "use_overwrite = False" in " ".join(calls(job("Render", Overwrite="false")[1])[-1])


def test_report(job):
    (words,) = calls(job("Report", Objects="Ball", AllowProblems="true")[1])
    assert words[:5] == [*START, "report", "/shared/a shot/ball.blend"]
    assert options(words[5:]) == {
        "--frames": ["1-5"], "--object": ["Ball"], "--allow-problems": [""], "--output": ["/shared/a shot/isochor"],
    }  # fmt: skip
    status, output = job("Report", Report="false")
    assert status == 0
    assert not calls(output)


def test_extension_is_installed_for_the_job_alone(job, tmp_path):
    package = tmp_path / "my isochor.zip"
    package.write_bytes(b"")
    status, output = job("Join", Extension=str(package))
    assert status == 0
    assert calls(output)[0][:2] == ["--command", "extension"]
    assert str(package) in calls(output)[0]
    assert "openjd_env: BLENDER_USER_RESOURCES=" in output
    assert "extension" not in calls(job("Join")[1])[0]


@pytest.mark.parametrize("step", ["Bake", "Join", "Report", "Render"])
def test_a_failing_blender_fails_the_task(job, step):
    status, output = job(step, status=3)
    assert status != 0
    assert len(calls(output)) == 1, "nothing may be run after the failure"


@pytest.mark.parametrize("wrong", [{"BakeChunkSize": 0}, {"Samples": 0}, {"CacheFormat": "abc"}, {"Resume": "maybe"}])
def test_refused(job, wrong):
    status, output = job("Bake", **wrong)
    assert status != 0
    assert not calls(output)
    assert next(iter(wrong)) in output


def test_parameters_say_what_they_are():
    for parameter in open_job.template()["parameterDefinitions"]:
        assert parameter["description"], parameter
        assert parameter["userInterface"]["label"], parameter
