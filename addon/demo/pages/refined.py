# SPDX-License-Identifier: GPL-3.0-or-later
"""Refinement without change: a posed lattice, the same pose with more points, and a detail that only those can make."""

from collections.abc import Iterator

import bpy
import numpy as np
from blender_session import DemoError
from figure import Array
from figure_stage import View, set_view
from gallery_scene import Staged, draw_lattice, evaluated_points, standing_column
from gallery_tile import Tile

NAME = "refined"
COLUMNS = 3
RESOLUTION, FINER = (3, 3, 5), (5, 5, 12)
BULGE = 1.3
"""How far the points of the detail are moved out, in widths of the lattice."""
VIEW = View(turn=0.0, rise=12.0, height=0.98, distance=8.4, size=(520, 440))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Coarse, refined, and edited."""
    staged = posed(scene)
    lines = draw_lattice(staged.lattice)
    yield staged.tile(points_words(staged))
    bpy.data.objects.remove(lines)
    apart = refined_apart(staged)
    lines = draw_lattice(staged.lattice)
    note = f"the lattice alone differs by {apart:.0e} of the size"
    yield staged.tile(f"refined: {points_words(staged)}", note=note)
    bpy.data.objects.remove(lines)
    bulge(staged)
    draw_lattice(staged.lattice)
    yield staged.tile("the finer key edited at one place")


def points_words(staged: Staged) -> str:
    """How many points the lattice has."""
    data = staged.lattice.data
    return f"{data.points_u} x {data.points_v} x {data.points_w} points, two shape keys"


def posed(scene: bpy.types.Scene) -> Staged:
    """The column under two shape keys of its lattice."""
    staged = Staged(scene, standing_column(), RESOLUTION, basis="BERNSTEIN", margin=0.06)
    set_view(scene, VIEW)
    staged.lattice.shape_key_add(name="Basis")
    for name, moved in (("Wave", wave), ("Twist", twist)):
        key = staged.lattice.shape_key_add(name=name, from_mix=False)
        rest = np.array([point.co for point in key.data], dtype=np.float64)
        key.data.foreach_set("co", moved(rest).astype(np.float32).reshape(-1))
        key.value = 0.8
    bpy.context.view_layer.update()
    return staged


def wave(places: Array) -> Array:
    """An S along the height. Places in the lattice run from -0.5 to 0.5."""
    x, y, z = places.T
    return np.stack([x + 0.42 * np.sin(5.0 * z), y, z - 0.06 * (z + 0.5)], axis=1)


def twist(places: Array) -> Array:
    """A turn about the height."""
    x, y, z = places.T
    angle = 1.1 * (z + 0.5)
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z], axis=1)


def refined_apart(staged: Staged) -> float:
    """Refines the lattice; largest move of a point under the lattice alone by that, in sizes of the object."""
    staged.put(Preserve=0.0)
    before = evaluated_points(staged.object)
    refine(staged)
    apart = np.abs(evaluated_points(staged.object) - before).max() / staged.size
    staged.put(Preserve=1.0)
    return float(apart)


def refine(staged: Staged) -> None:
    """Gives the lattice its finer resolution."""
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = staged.object
    staged.object.select_set(True)
    if bpy.ops.isochor.refine(resolution=FINER) != {"FINISHED"}:
        raise DemoError("isochor.refine did not finish: see its message above")
    bpy.context.view_layer.update()


def bulge(staged: Staged) -> None:
    """Moves a few points of one shape key out of one side, half up."""
    key = staged.lattice.data.shape_keys.key_blocks["Wave"]
    rest = np.array([point.co for point in staged.lattice.data.shape_keys.key_blocks["Basis"].data])
    side = rest[:, 0] >= np.unique(rest[:, 0].round(4))[-2] - 1e-3
    near = side & (np.abs(rest[:, 2]) < 0.1) & (np.abs(rest[:, 1]) < 0.3)
    for number in np.flatnonzero(near):
        key.data[int(number)].co.x += BULGE
    staged.lattice.data.update_tag()
    bpy.context.view_layer.update()
