# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender and the extension that the jobs are run with, and what a bake in one go makes of the same shot.

Use: pytest tests/farm --blender PROGRAM --extension ZIP, with BLENDER_USER_RESOURCES naming an empty folder; without
them, the tests that run Blender are skipped.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import pytest
from running import ran

HERE = Path(__file__).resolve().parent
FRAMES = "1-5"
CAMERA_FRAMES = range(1, 6)


def pytest_addoption(parser):
    parser.addoption("--blender", help="the Blender that runs the jobs")
    parser.addoption("--extension", type=Path, help="the built zip, to install in it")


@dataclass(frozen=True)
class Reference:
    """What one process makes of the shot: caches in one folder, frames in the other."""

    caches: Path
    frames: Path


def checked(*command):
    """The output of a command, which has to end well."""
    status, output = ran([str(word) for word in command])
    assert status == 0, output
    return output


@pytest.fixture(scope="session")
def extension(request):
    """The built zip."""
    return request.config.getoption("--extension") or pytest.skip("needs --extension")


@pytest.fixture(scope="session")
def blender(request, extension):
    """The Blender, in which the zip is installed as a user would."""
    program = request.config.getoption("--blender") or pytest.skip("needs --blender")
    assert not any(Path(os.environ["BLENDER_USER_RESOURCES"]).iterdir()), "give BLENDER_USER_RESOURCES an empty folder"
    checked(program, "--command", "extension", "install-file", "-r", "user_default", "--enable", extension)
    return program


@pytest.fixture(scope="session")
def shot(blender, tmp_path_factory):
    """A file with two deformed objects, in a folder with a space."""
    place = tmp_path_factory.mktemp("farm") / "a shot" / "two balls.blend"
    place.parent.mkdir()
    checked(blender, "--background", "--python-exit-code", "1", "--python", HERE / "make_shot.py", "--", place)
    return place


@pytest.fixture(scope="session")
def reference(blender, shot):
    """The shot baked by one command and rendered by another, with the add-on and no cache."""
    found = Reference(shot.parent / "in one go", shot.parent / "frames in one go")
    bake = [blender, "--background", "--command", "isochor", "bake", shot]
    checked(*bake, "--frames", FRAMES, "--output", found.caches)
    checked(blender, "--background", shot, "--render-output", found.frames / "frame_####", "-a")
    return found
