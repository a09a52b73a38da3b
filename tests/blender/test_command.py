# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: parts made apart give the bytes of one bake in one go; what goes wrong is told and ends with 1."""

from pathlib import Path

import bpy
import processes
import pytest
import scenes

FRAMES = 10


@pytest.fixture
def film(tmp_path: Path) -> Path:
    """A saved file with two balls, each squashed by a keyed lattice of its own."""
    for name in ("Ball", "Other"):
        ball = scenes.sphere(16, 10, name=name)
        lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
        scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    place = tmp_path / "film.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(place))
    return place


def command(*words: object) -> int:
    """The handler itself, in this process."""
    return scenes.part("tool.command_line").run([str(word) for word in words])


def test_parts_in_any_order_give_the_bytes_of_one_bake(film, tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "apart"
    assert command("bake", film, "--frames", "1-10", "--output", whole) == 0
    for chunk in ("7-10", "1-3", "4-6"):
        assert command("bake", film, "--frames", chunk, "--part-of", "1-10", "--output", parts) == 0
    assert command("join", film, "--frames", "1-10", "--output", parts) == 0
    for name in ("Ball.pc2", "Other.pc2"):
        assert (whole / name).read_bytes() == (parts / name).read_bytes()


def test_the_command_of_a_new_blender(film, tmp_path):
    done = processes.run_command("bake", film, "--frames", "1-3", "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "openjd_progress: 100.0" in done.stdout.splitlines()
    assert (tmp_path / "out" / "Ball.pc2").is_file()
    failed = processes.run_command("bake", film, "--frames", "1-3", "--output", tmp_path / "out", "--object", "Nobody")
    assert failed.returncode == 1
    assert "isochor: There is no object “Nobody”" in failed.stderr
