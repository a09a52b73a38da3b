# SPDX-License-Identifier: GPL-3.0-or-later
"""Several lattices on one mesh: overlapping, side by side and tied, one in another."""

from collections.abc import Callable, Iterator

import bpy
import numpy as np
from figure_stage import View, set_view
from gallery_scene import Staged, draw_lines, standing_column
from gallery_tile import Tile
from numpy.typing import NDArray
from volume_lattice import get_input, set_input

NAME = "blocks"
COLUMNS = 3
VIEW = View(turn=0.0, rise=15.0, height=0.95, distance=8.6)
SHAPE = (4, 4, 5)
JOINT = 0.48
"""Part of the column's height at which two blocks meet."""
BEND = 1.0
"""Angle, in radians, of the arc into which the column is bent."""

Array = NDArray[np.float64]


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """Two that overlap; two end to end, free and tied; a bulge on a column that bends, in the stack and nested."""
    staged = fresh(scene)
    upper = add(staged, (0.36, 1.0), wide=1.3)
    low, height = staged.lattice.location.z - staged.lattice.scale.z / 2.0, staged.lattice.scale.z
    span(staged.lattice, low, height, (0.0, 0.64))
    reshape(staged.lattice, lambda places: swollen(places, 1.35))
    reshape(upper, lambda places: places + 0.5 * (np.abs(places[:, 2:]) < 0.1) * (1.0, 0.0, 0.0))
    yield shown(staged, [staged.lattice, upper], "two that overlap")
    for continuity in ("", "C0", "C1"):
        yield side_by_side(scene, continuity)
    staged = fresh(scene)
    small = add(staged, (0.25, 0.75), wide=1.25, first=True)
    reshape(small, swollen)
    reshape(staged.lattice, bent)
    staged.put(Outside="Extend")
    yield shown(staged, [staged.lattice], "a bulge, then the bend of it all")
    staged = fresh(scene)
    outer = staged.lattice.copy()
    outer.data = staged.lattice.data.copy()
    scene.collection.objects.link(outer)
    staged.lattice.modifiers.new("Outer", "LATTICE").object = outer
    reshape(staged.lattice, swollen)
    reshape(outer, bent)
    yield shown(staged, [staged.lattice], "a lattice that another bends")


def side_by_side(scene: bpy.types.Scene, continuity: str) -> Tile:
    """The upper layer of the lower block pushed to the side; the upper block follows if it is tied."""
    staged = fresh(scene)
    height = staged.lattice.scale.z
    upper = add(staged, (JOINT, 1.0))
    span(staged.lattice, staged.lattice.location.z - height / 2.0, height, (0.0, JOINT))
    if continuity:
        select(staged.lattice, upper)
        bpy.ops.isochor.tie_lattices(continuity=continuity)
    reshape(staged.lattice, lambda places: places + 0.32 * ((places[:, 2:] + 0.5) > 0.9) * (1.0, 0.0, 0.0))
    return shown(staged, [staged.lattice, upper], f"tied {continuity}" if continuity else "side by side, not tied")


def fresh(scene: bpy.types.Scene) -> Staged:
    """A column at rest on an empty stage."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    staged = Staged(scene, standing_column(), SHAPE, basis="BERNSTEIN")
    staged.put(Axes=(1.0, 1.0, 1.0))
    set_view(scene, VIEW)
    return staged


def add(staged: Staged, between: tuple[float, float], wide: float = 1.0, first: bool = False) -> bpy.types.Object:
    """One more lattice, as high as between two parts of the column's, and wider; ``first``: before the other one, which
    then still corrects for both."""
    before = staged.lattice
    select(staged.object)
    bpy.ops.isochor.add(resolution=SHAPE, basis="BERNSTEIN", only_last=not first)
    modifier = staged.object.modifiers[-1]
    lattice = get_input(modifier, "Lattice")
    span(lattice, before.location.z - before.scale.z / 2.0, before.scale.z, between)
    lattice.scale.x *= wide
    lattice.scale.y *= wide
    if first:
        set_input(modifier, "Preserve", 0.0)
        staged.object.modifiers.move(1, 0)
    staged.modifier = staged.object.modifiers[-1]
    bpy.context.view_layer.update()
    return lattice


def span(lattice: bpy.types.Object, low: float, height: float, between: tuple[float, float]) -> None:
    """Has a lattice reach between two parts of a height that begins at ``low``."""
    lattice.scale.z = (between[1] - between[0]) * height
    lattice.location.z = low + height * (between[0] + between[1]) / 2.0
    bpy.context.view_layer.update()


def reshape(lattice: bpy.types.Object, shape: Callable[[Array], Array]) -> None:
    """Puts the lattice's points, which rest in the unit cube about the origin, where ``shape`` says."""
    rest = np.array([tuple(point.co) for point in lattice.data.points])
    lattice.data.points.foreach_set("co_deform", shape(rest).astype(np.float32).reshape(-1))
    lattice.data.update_tag()
    bpy.context.view_layer.update()


def swollen(places: Array, factor: float = 1.5) -> Array:
    """The middle layer drawn outwards; the two on either side keep still, and with them what is beyond."""
    middle = np.abs(places[:, 2:]) < 0.1
    return places * np.where(middle, (factor, factor, 1.0), 1.0)


def bent(places: Array) -> Array:
    """Bent into an arc over the height, the foot in place; in units of a column that is twice as high as wide."""
    angle = BEND * (places[:, 2] + 0.5)
    radius = 2.0 / BEND - places[:, 0]
    x, z = 2.0 / BEND - radius * np.cos(angle), radius * np.sin(angle) / 2.0 - 0.5
    return np.column_stack([x, places[:, 1], z])


def shown(staged: Staged, lattices: list[bpy.types.Object], caption: str) -> Tile:
    """The stage as it stands, with the lattices as they are evaluated drawn in it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for lattice in lattices:
        held = lattice.evaluated_get(depsgraph)
        places = np.array([held.matrix_world @ point.co_deform for point in held.data.points])
        shape = held.data.points_w, held.data.points_v, held.data.points_u, 3
        draw_lines(f"{lattice.name} Lines", places.reshape(shape))
    return staged.tile(caption)


def select(*objects: bpy.types.Object) -> None:
    """Selects these alone; the first is active."""
    bpy.ops.object.select_all(action="DESELECT")
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
