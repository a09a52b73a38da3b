# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles a Flamenco job type in a JavaScript engine, and turns its tasks into command lines as a worker does.

After Flamenco's documentation (job types, list of commands) and the behaviour of its Manager and Worker, 3.6 to 3.9.
"""

import json
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import quickjs
from running import Task

HERE = Path(__file__).resolve().parent
# The commands this project uses, with the type of each parameter; "exeArgs" alone may be left out.
COMMANDS = {"blender-render": {"exe": str, "exeArgs": str, "argsBefore": list, "blendfile": str, "args": list}}


class Refused(Exception):
    """What the script throws, or what the Manager or a worker would refuse."""


@dataclass(frozen=True)
class Job:
    """A compiled job: the settings as the script left them, and the tasks as the Manager stores them."""

    settings: dict[str, Any]
    tasks: list[dict[str, Any]]

    def task(self, name: str) -> dict[str, Any]:
        return next(task for task in self.tasks if task["name"] == name)

    def names(self, start: str) -> list[str]:
        return [task["name"] for task in self.tasks if task["name"].startswith(start)]


class Script:
    """A job compiler script, loaded."""

    def __init__(self, place: Path) -> None:
        self._source = place.read_text(encoding="utf-8")

    def job_type(self) -> dict[str, Any]:
        """JOB_TYPE as the Manager passes it on: as JSON."""
        return json.loads(self._engine().eval("JSON.stringify(JOB_TYPE)"))

    def compiled(self, **settings: Any) -> Job:
        """The job with these settings, the others at their defaults."""
        declared = self.job_type()["settings"]
        keys = [setting["key"] for setting in declared]
        unknown = sorted(settings.keys() - set(keys))
        if unknown:
            raise Refused(f"the job type has no setting {', '.join(unknown)}")
        values = {setting["key"]: setting["default"] for setting in declared if "default" in setting} | settings
        try:
            answer = self._engine().eval(f"JSON.stringify(compiled({json.dumps(keys)}, {json.dumps(values)}))")
        except quickjs.JSException as error:
            raise Refused(str(error)) from error
        return Job(**json.loads(answer))

    def _engine(self) -> quickjs.Context:
        """A fresh engine for each, in strict mode like the Manager's."""
        engine = quickjs.Context()
        engine.add_callable("hostFrameChunker", _answering(frame_chunks))
        engine.add_callable("hostFrameCount", _answering(lambda frames: len(exploded(frames))))
        engine.add_callable("hostShellSplit", _answering(shlex.split))
        engine.eval((HERE / "flamenco_author.js").read_text(encoding="utf-8"))
        engine.eval('"use strict";\n' + self._source)
        return engine


def commands(job: Job, variables: Mapping[str, str]) -> list[Task]:
    """The job's tasks as command lines with the Manager's variables in the place of {name}."""
    return [
        Task(task["name"], [argv(command, variables) for command in task["commands"]], tuple(task["dependencies"]))
        for task in job.tasks
    ]


def argv(command: Mapping[str, Any], variables: Mapping[str, str]) -> list[str]:
    """The command line of one command: exe, exeArgs, argsBefore, blendfile, args."""
    kinds = COMMANDS.get(command["name"])
    if kinds is None:
        raise Refused(f"a worker has no command {command['name']} (or this test does not know it)")
    given = dict(command["parameters"])
    wrong = [key for key in given.keys() | kinds.keys() if not isinstance(given.get(key), kinds.get(key, ()))]
    if sorted(wrong) not in ([], ["exeArgs"]):
        raise Refused(f"{command['name']}: missing, unknown or of the wrong type: {', '.join(wrong)}")
    exe, blend_file = _expanded(given["exe"], variables), _expanded(given["blendfile"], variables)
    before = shlex.split(_expanded(given.get("exeArgs", ""), variables)) + given["argsBefore"]
    words = [exe, *before, *([blend_file] if blend_file else []), *given["args"]]
    return [_expanded(word, variables) for word in words]


def frame_chunks(frames: str, size: int) -> list[str]:
    """Chunks of at most that many frames: runs of three and more as "1-3", the others by commas."""
    if size < 1:
        raise ValueError(f"invalid chunk size, must be positive number: {size}")
    found = exploded(frames)
    return [_merged(found[start : start + size]) for start in range(0, len(found), size)]


def exploded(frames: str) -> list[int]:
    """The frames of a range such as "1..10, 20-25, 40", in order, each once."""
    found: set[int] = set()
    for piece in frames.replace("..", "-").split(","):
        ends = [int(end) for end in piece.split("-")]
        if len(ends) > 2:
            raise ValueError(f"invalid range {piece!r}")
        found.update(range(ends[0], ends[-1] + 1))
    if not found:
        raise ValueError(f"invalid range {frames!r}: empty range")
    return sorted(found)


def _merged(frames: list[int]) -> str:
    runs: list[list[int]] = []
    for frame in frames:
        if runs and frame == runs[-1][-1] + 1:
            runs[-1].append(frame)
        else:
            runs.append([frame])
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ",".join(map(str, run)) for run in runs)


def _expanded(text: str, variables: Mapping[str, str]) -> str:
    for name, value in variables.items():
        text = text.replace(f"{{{name}}}", value)
    return text


def _answering(function: Callable[..., Any]) -> Callable[..., str]:
    """The function for the engine: its result or its error as JSON, for no other value can cross."""

    def answer(*given: Any) -> str:
        try:
            return json.dumps({"value": function(*given)})
        except ValueError as error:
            return json.dumps({"error": str(error)})

    return answer
