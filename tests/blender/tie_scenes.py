# SPDX-License-Identifier: GPL-3.0-or-later
"""A bar in a row of adjacent blocks of different length, and what joints between them look like."""

import bpy
import numpy as np
import scenes

ENDS = (-2.0, -0.8, 0.7, 2.0)
"""Along x: where the blocks of a bar begin and end."""
SIDE = 0.5
STEP = 2.0**-8
"""Distance of the rings of vertices on either side of a joint."""


def bar(ends: tuple[float, ...] = ENDS, name: str = "Bar") -> bpy.types.Object:
    """A closed bar along x, triangulated, with rings of vertices on each joint and right beside it."""
    inner = [x + step for x in ends[1:-1] for step in (-STEP, 0.0, STEP)]
    places = np.unique(np.concatenate([np.linspace(ends[0] + 0.05, ends[-1] - 0.05, 17), inner]))
    side = np.linspace(-1.0, 1.0, 4)
    ring = [(y, -1.0) for y in side[:-1]] + [(1.0, z) for z in side[:-1]]
    ring += [(-y, 1.0) for y in side[:-1]] + [(-1.0, -z) for z in side[:-1]]
    around = 0.9 * SIDE * np.array(ring)
    points = [(x, y, z) for x in places for y, z in around]
    count = len(around)
    faces = []
    for row in range(len(places) - 1):
        for number in range(count):
            a, b = row * count + number, row * count + (number + 1) % count
            faces += [(a, b, b + count), (a, b + count, a + count)]
    for row, order in ((0, -1), (len(places) - 1, 1)):
        points.append((places[row], 0.0, 0.0))
        rim = [(row * count + number, row * count + (number + 1) % count) for number in range(count)]
        faces += [(*edge[::order], len(points) - 1)[::1] for edge in rim]
    obj = scenes.mesh_object(name, points, [face[::-1] for face in faces])
    if scenes.volume(obj.data) < 0.0:
        obj.data.flip_normals()
    return obj


def blocks(
    shapes: tuple[tuple[int, int, int], ...] = ((4, 3, 3), (5, 3, 3), (4, 3, 3)), basis: str = "Bernstein"
) -> list[bpy.types.Object]:
    """Lattices side by side along x, whose domains meet at ENDS."""
    found = []
    for number, shape in enumerate(shapes):
        low, high = ENDS[number], ENDS[number + 1]
        lattice = scenes.lattice_object(shape, name=f"Block {number}")
        size = np.array([high - low, 2 * SIDE, 2 * SIDE])
        if basis == "B-Spline":
            degree = np.minimum(3, np.array(shape) - 1)
            size *= (np.array(shape) - 1) / (np.array(shape) - degree)
        lattice.scale = size
        lattice.location = ((low + high) / 2.0, 0.0, 0.0)
        found.append(lattice)
    bpy.context.view_layer.update()
    return found


def select(*lattices: bpy.types.Object) -> None:
    """Selects them; the first is active."""
    scenes.choose(lattices[0])
    for lattice in lattices:
        lattice.select_set(True)


def tied_bar(
    continuity: str = "C1", basis: str = "Bernstein", **inputs: object
) -> tuple[bpy.types.Object, list[bpy.types.Object], list[bpy.types.NodesModifier]]:
    """The bar in three blocks of which the first leads."""
    obj = bar()
    found = blocks(basis=basis) if basis == "Bernstein" else blocks(((6, 4, 4), (7, 4, 4), (6, 4, 4)), basis)
    modifiers = [scenes.volume_lattice(obj, lattice, Basis=basis, **inputs) for lattice in found]
    select(*found)
    assert bpy.ops.isochor.tie_lattices(continuity=continuity) == {"FINISHED"}
    return obj, found, modifiers


def push(lattice: bpy.types.Object, where: int, amount: tuple[float, float, float], axis: int = 0) -> None:
    """Moves a layer of points along u, unevenly."""
    data = lattice.data
    for index, point in enumerate(data.points):
        layer = (index % data.points_u, index // data.points_u % data.points_v)[axis]
        if layer == where % (data.points_u, data.points_v)[axis]:
            point.co_deform = [
                here + by * (1.0 + 0.5 * point.co.y) for here, by in zip(point.co_deform, amount, strict=True)
            ]
    bpy.context.view_layer.update()


def joint(obj: bpy.types.Object, number: int, depsgraph: bpy.types.Depsgraph | None = None) -> tuple[float, float]:
    """Of the bar at one of its joints: the largest jump of the slope along it, and how far the joint has moved."""
    rest, now = scenes.positions(obj.data), scenes.evaluated_positions(obj, depsgraph)
    place = ENDS[number]
    rings = [np.flatnonzero(np.abs(rest[:, 0] - place - step) < STEP / 4) for step in (-STEP, 0.0, STEP)]
    assert len({len(ring) for ring in rings}) == 1
    before, at, after = (now[ring] for ring in rings)
    slopes = (at - before) / STEP, (after - at) / STEP
    moved = np.linalg.norm(at - rest[rings[1]], axis=1).max()
    return float(np.linalg.norm(slopes[1] - slopes[0], axis=1).max()), float(moved)


def error(obj: bpy.types.Object) -> float:
    """Of the volume that Blender shows, against the object's own."""
    return abs(scenes.evaluated_volume(obj) / scenes.volume(obj.data) - 1.0)


def deformed(lattice: bpy.types.Object) -> np.ndarray:
    """(N, 3) points of the lattice's own data."""
    found = np.empty(len(lattice.data.points) * 3, np.float32)
    lattice.data.points.foreach_get("co_deform", found)
    return found.reshape(-1, 3)
