# SPDX-License-Identifier: GPL-3.0-or-later
"""Alembic and USD: what is exported from an animated Volume Lattice and imported again is what was seen."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
import scenes
from numpy.typing import NDArray

FRAMES = 8


def bouncing() -> bpy.types.Object:
    """A ball that moves and turns, whose keyed lattice squashes it, behind a modifier that subdivides it less in the
    viewport than in renders."""
    ball = scenes.sphere(16, 10)
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    subdivision = ball.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 0, 1
    scenes.volume_lattice(ball, lattice, Basis="B-Spline")
    for frame, turn in ((1, 0.0), (FRAMES, 0.7)):
        ball.location.x = ball.rotation_euler.y = turn
        ball.keyframe_insert("location", frame=frame)
        ball.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.context.scene.frame_set(3)
    return ball


def world_shapes(obj: bpy.types.Object) -> list[NDArray[np.float64]]:
    """(V, 3) vertices in world space in each frame."""
    found = []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        points, matrix = scenes.evaluated_positions(obj), np.array(obj.matrix_world)
        found.append(points @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def baked_world_shapes(obj: bpy.types.Object, cache: Path) -> list[NDArray[np.float64]]:
    """The same of what renders see, as a bake holds it, which is freed again."""
    assert bpy.ops.isochor.bake(format="PC2", filepath=str(cache)) == {"FINISHED"}
    held = np.array(scenes.part("core.point_cache").read(cache)[1])
    assert bpy.ops.isochor.free_bake() == {"FINISHED"}
    found = []
    for frame, shape in enumerate(held, 1):
        bpy.context.scene.frame_set(frame)
        matrix = np.array(obj.matrix_world)
        found.append(shape @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def through_alembic(place: Path, mode: str) -> None:
    bpy.ops.wm.alembic_export(
        filepath=str(place), start=1, end=FRAMES, selected=True, evaluation_mode=mode, as_background_job=False
    )
    scenes.empty_file()
    bpy.ops.wm.alembic_import(filepath=str(place), as_background_job=False)


def through_usd(place: Path, mode: str) -> None:
    bpy.ops.wm.usd_export(filepath=str(place), export_animation=True, selected_objects_only=True, evaluation_mode=mode)
    scenes.empty_file()
    bpy.ops.wm.usd_import(filepath=str(place))


def lacking(option: str) -> pytest.MarkDecorator:
    """Skips in a Blender built without this, as Debian's; Blender's own builds and the bpy wheels have it."""
    missing = not bpy.app.module and not getattr(bpy.app.build_options, option)
    return pytest.mark.skipif(missing, reason=f"this Blender is built without {option}")


EXCHANGES = [
    pytest.param("abc", through_alembic, marks=lacking("alembic"), id="alembic"),
    pytest.param("usdc", through_usd, marks=lacking("usd"), id="usd"),
]


@pytest.mark.parametrize("mode", ["VIEWPORT", "RENDER"])
@pytest.mark.parametrize(("suffix", "through"), EXCHANGES)
def test_what_is_exported_comes_back_as_it_was_seen(
    tmp_path: Path, suffix: str, through: Callable[[Path, str], None], mode: str
):
    ball = bouncing()
    wanted = baked_world_shapes(ball, tmp_path / "Ball.pc2") if mode == "RENDER" else world_shapes(ball)
    assert np.ptp(wanted[3], axis=0)[2] < 0.8 * np.ptp(wanted[0], axis=0)[2]
    bpy.context.scene.frame_set(3)
    scenes.choose(ball)
    through(tmp_path / f"ball.{suffix}", mode)
    back = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    found = world_shapes(back)
    assert len(found[0]) == len(wanted[0])
    assert max(np.abs(one - other).max() for one, other in zip(found, wanted)) < 5e-6
    assert not [found.name for found in scenes.evaluated_mesh(back).attributes if "isochor" in found.name]
