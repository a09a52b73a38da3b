# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks and runs the Open Job Description template with its own command-line tool, `openjd`."""

import json
import os
import sys
from pathlib import Path
from typing import Any

import yaml
from places import FARM
from running import ran

TEMPLATE = FARM / "openjd" / "template.yaml"
TOOL = [str(Path(sys.executable).with_name("openjd"))]


def template() -> dict[str, Any]:
    """The template's own contents."""
    return yaml.safe_load(TEMPLATE.read_text(encoding="utf-8"))


def check() -> tuple[int, str]:
    """Exit status and output of the tool's validation."""
    return ran([*TOOL, "check", str(TEMPLATE)])


def summary(parameters: dict[str, Any]) -> dict[str, Any]:
    """The job that these parameters make of the template."""
    status, output = ran([*TOOL, "summary", str(TEMPLATE), "-p", json.dumps(parameters), "--output", "json"])
    assert status == 0, output
    return json.loads(output)


def run(step: str, parameters: dict[str, Any], sessions: Path, *choice: str) -> tuple[int, str]:
    """Runs the step on this machine, without words of choice with all its tasks and all steps that it depends on."""
    words = ["-p", json.dumps(parameters), "--step", step, *(choice or ["--run-dependencies"])]
    return ran([*TOOL, "run", str(TEMPLATE), *words], env={**os.environ, "TMPDIR": str(sessions)})
