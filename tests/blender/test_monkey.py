# SPDX-License-Identifier: GPL-3.0-or-later
"""Thousands of random steps in a Blender of its own end without a crash, an exception or a wrong volume."""

import os
import re
import subprocess
import tempfile
from pathlib import Path

import other_blender
import pytest
from installed_extension import ISOLATION, ZIP

SCRIPT = Path(__file__).with_name("monkey.py")
STEPS = 1500
LIMIT_S = 600.0


@pytest.mark.parametrize("seed", [1, 2])
def test_a_monkey_breaks_nothing(seed):
    user = tempfile.mkdtemp(prefix="isochor-monkey-user-")
    command = other_blender.command(SCRIPT, "--zip", os.environ[ZIP], "--seed", seed, "--steps", STEPS)
    done = subprocess.run(command, env={**os.environ, ISOLATION: user}, capture_output=True, text=True, timeout=LIMIT_S)
    lines = [line for line in done.stdout.splitlines() if not line.startswith("Isochor: ")]
    assert done.returncode == 0, "\n".join([*lines[-60:], done.stderr[-4000:]])
    counted = re.search(r"(\d+) steps, (\d+) volumes measured", done.stdout)
    assert counted is not None
    assert int(counted[1]) == STEPS
    assert int(counted[2]) > STEPS / 3, "too few volumes were looked at for the test to mean anything"
