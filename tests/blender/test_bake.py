# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to point caches: what plays afterwards, without the add-on, is what was seen before."""

import bpy
import numpy as np
import pytest
import scenes

FRAMES = 8


def bouncing(name: str = "Ball", columns: int = 16, rows: int = 10) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A ball whose lattice, keyed over the frames, squashes and shears it; the object moves too."""
    ball = scenes.sphere(columns, rows, name=name)
    lattice = scenes.squashing_lattice(ball, 6, frames=FRAMES)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    bpy.context.scene.frame_set(1)
    return ball, scenes.volume_lattice(ball, lattice, Basis="B-Spline")


def shapes(obj: bpy.types.Object, frames) -> list:
    """What Blender draws of the object in each frame, some of them fractions."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
        found.append(scenes.evaluated_positions(obj))
    return found


@pytest.mark.parametrize("kind", ["PC2", "MDD"])
def test_a_bake_plays_what_was_seen(tmp_path, kind):
    ball, modifier = bouncing()
    before = shapes(ball, range(1, FRAMES + 1))
    assert np.ptp(before[3], axis=0)[2] < 0.8 * np.ptp(before[0], axis=0)[2]
    scenes.choose(ball)
    assert bpy.ops.isochor.bake(format=kind, directory=str(tmp_path)) == {"FINISHED"}
    assert [m.type for m in ball.modifiers] == ["NODES", "MESH_CACHE"]
    assert not modifier.show_viewport
    assert not modifier.show_render
    after = shapes(ball, range(1, FRAMES + 1))
    assert max(np.abs(one - other).max() for one, other in zip(before, after)) < 1e-6
