# SPDX-License-Identifier: GPL-3.0-or-later
"""A squashed ball whose surface is held by pins, and what must be true of it."""

from typing import Any

import bpy
import numpy as np
import scenes
from numpy.typing import NDArray

NEAR, FAR = 40, 200
"""Two vertices of the ball, on either side of it."""
SIZE = 2.0
"""Of the ball."""
EXACT = 1e-6 * SIZE


def squashed_ball(
    name: str = "Ball", squash: float = 0.7, side: int = 5, size: float = 2.6, **inputs: Any
) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A ball whose lattice is pressed to a fraction of its height."""
    ball = scenes.sphere(name=name)
    lattice = scenes.lattice_object(side, name=f"{name} Cage", size=size)
    modifier = scenes.volume_lattice(ball, lattice, **inputs)
    for point in lattice.data.points:
        point.co_deform.z *= squash
    bpy.context.view_layer.update()
    return ball, modifier


def pin(ball: bpy.types.Object, *vertices: int) -> list[bpy.types.Object]:
    """Pins these vertices, which are then the only ones selected; the empties in the same order."""
    scenes.choose(ball)
    flags = np.isin(np.arange(len(ball.data.vertices)), vertices)
    ball.data.vertices.foreach_set("select", flags)
    before = set(bpy.data.objects)
    assert bpy.ops.isochor.add_pin() == {"FINISHED"}
    bpy.context.view_layer.update()
    made = [obj for obj in bpy.data.objects if obj not in before]
    record = scenes.part("tool.pin_record")
    mark = record.mark_of(scenes.part("tool.stack").ours(ball)[-1])
    by_vertex = {next(iter(record.read(obj, mark).places.values())).corners[0]: obj for obj in made}
    return [by_vertex[vertex] for vertex in vertices]


def place(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> NDArray[np.float64]:
    """Where an object is in the world, as evaluated."""
    held = obj.evaluated_get(depsgraph or bpy.context.evaluated_depsgraph_get())
    return np.array(held.matrix_world.translation, np.float64)


def in_world(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> NDArray[np.float64]:
    """(V, 3) what Blender draws of an object, in the world."""
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    matrix = np.array(obj.evaluated_get(depsgraph).matrix_world, np.float64)
    return scenes.evaluated_positions(obj, depsgraph) @ matrix[:3, :3].T + matrix[:3, 3]


def holds(ball: bpy.types.Object, empty: bpy.types.Object, vertex: int) -> bool:
    """Whether the vertex is where the empty is."""
    return float(np.linalg.norm(in_world(ball)[vertex] - place(empty))) <= EXACT


def keeps_volume(ball: bpy.types.Object) -> bool:
    """Whether what is drawn encloses as much as the mesh itself."""
    return abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1.0) <= 1e-6


def problems(ball: bpy.types.Object, modifier: bpy.types.NodesModifier) -> str:
    """All that is wrong, in one text."""
    return " ".join(scenes.report(ball, modifier).problems)


def move(obj: bpy.types.Object, *way: float) -> None:
    """Moves an object, and has Blender evaluate that."""
    obj.location = np.array(obj.location) + way
    bpy.context.view_layer.update()
