# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates a lattice as an elastic body over a range of frames."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import bpy
import numpy as np
from numpy.typing import NDArray

import isochor

from ..core import grid, problem, simulation
from ..core.report import Report
from ..core.settings import Settings
from . import evaluated, lattice_weights, lattices, state

Array = NDArray[np.float64]
Plane = tuple[Array, Array]
"""A point, and the normal away from the ground."""

Users = list[tuple[bpy.types.Object, bpy.types.NodesModifier]]

PINNED_FROM = 0.5
"""Weight in the vertex group from which on a point is pinned."""


@dataclass(frozen=True)
class Range:
    """Frames of the simulation, the last included, and what in them comes from the animation."""

    start: int
    end: int
    use_motion: bool
    pin_group: str


@dataclass
class Shapes:
    """The result: flat float32 points of the lattice, u fastest, in its own space, for each frame from ``first`` on."""

    first: int
    points: list[NDArray[np.float32]]


@dataclass(frozen=True)
class Sight:
    """What one frame of the animation shows of a lattice: matrix to world, world control points (nu, nv, nw, 3)."""

    matrix: Array
    control: Array
    local: NDArray[np.float32]


def simulate(
    context: bpy.types.Context,
    lattice: bpy.types.Object,
    users: Users,
    span: Range,
    options: simulation.Options,
    shapes: Shapes,
) -> Iterator[float]:
    """Fills ``shapes``, and yields how much is done, from 0 to 1. Leaves the scene at another frame.

    Frames of the scene before the simulation get the animator's shape. Raises Problem and isochor.Error.
    """
    scene = context.scene
    first = min(scene.frame_start, span.start)
    shapes.first, shapes.points = first, []
    still = is_still(lattice)
    before = None
    for frame in range(first, span.start):
        before = look(context, lattice, frame)
        shapes.points.append(before.local)
        yield 0.0
    if before is None and span.use_motion:
        before = look(context, lattice, span.start - 1)
    sight = look(context, lattice, span.start)
    fps = scene.render.fps / scene.render.fps_base
    shapes.points.append(sight.local)
    velocity = np.zeros_like(sight.control)
    if before is not None and span.use_motion:
        velocity = (sight.control - before.control) * fps
    pinned = pinned_points(lattice, span.pin_group)
    body = body_of(lattice, users, sight, velocity, pinned, options)
    for frame in range(span.start + 1, span.end + 1):
        if not still or pinned.any():
            sight = look(context, lattice, frame)
        body.step(1.0 / fps, sight.control if pinned.any() else None)
        shapes.points.append(simulation.in_blender(body.control, sight.matrix))
        yield (frame - span.start) / (span.end - span.start)


def is_still(lattice: bpy.types.Object) -> bool:
    """Whether the lattice object surely stands in the same place in every frame."""
    return lattice.animation_data is None and lattice.parent is None and not lattice.constraints


def look(context: bpy.types.Context, lattice: bpy.types.Object, frame: int) -> Sight:
    """The lattice as animated in a frame."""
    context.scene.frame_set(frame)
    shown = lattice.evaluated_get(context.evaluated_depsgraph_get())
    points = evaluated.lattice_points(shown)
    matrix = evaluated.matrix(shown)
    if abs(np.linalg.det(grid.unit_columns(matrix))) < 1e-12:
        raise problem.Problem(problem.flat_lattice(lattice.name))
    world = grid.Grid(points.shape, points.low, points.high, "Bernstein", matrix)
    return Sight(matrix, grid.control_points(world, points.deformed), points.deformed)


def body_of(
    lattice: bpy.types.Object,
    users: Users,
    sight: Sight,
    velocity: Array,
    pinned: NDArray[np.bool_],
    options: simulation.Options,
) -> isochor.Elastic:
    """The elastic body of the lattice as it stands now, carrying the meshes of these modifiers."""
    rest, settings, skins = None, Settings(), []
    for obj, modifier in users:
        memory = state.recall(obj, modifier)
        asked = None if memory is None else memory.asked
        if memory is None or asked is None or memory.report.binding is None:
            continue
        if asked.bound is not None and asked.bound.is_shaped:
            raise problem.Problem(problem.rest_shaped(lattice.name, obj.name))
        if rest is None:
            rest = replace(asked.embedding_grid, to_object=evaluated.matrix(obj) @ asked.embedding_grid.to_object)
            settings = asked.settings
        if asked.embedding_grid.basis == rest.basis:
            skins.append(simulation.skin_of(asked, rest, volume_factor(memory.report)))
    if rest is None or not skins:
        names = ", ".join(obj.name for obj, _modifier in users)
        raise problem.Problem(problem.nothing_carried(lattice.name, names))
    return simulation.body(rest, simulation.joined(skins), sight.control, velocity, pinned, settings, options)


def volume_factor(report: Report) -> float | None:
    """The volume that is kept over that of the mesh which enters; None where none is kept."""
    if report.volumes is None or report.binding is None:
        return None
    return report.volumes.target / report.binding.reference_volume


def pinned_points(lattice: bpy.types.Object, group_name: str) -> NDArray[np.bool_]:
    """(nu, nv, nw): which points are led by the animation."""
    data = lattice.data
    if not group_name:
        return np.zeros((data.points_u, data.points_v, data.points_w), np.bool_)
    weights = lattice_weights.of_group(lattice, group_name)
    if weights is None:
        raise problem.Problem(problem.no_pin_group(group_name, lattice.name))
    return np.asarray(weights >= PINNED_FROM)


def users_in(context: bpy.types.Context, lattice: bpy.types.Object) -> Users:
    """The modifiers of this view layer that the lattice shapes."""
    shown = context.view_layer.objects
    return [(obj, modifier) for obj, modifier in lattices.users_of(lattice) if obj.name in shown]


def level_ground(height: float) -> Plane:
    """Level ground at that height."""
    return np.array([0.0, 0.0, height]), np.array([0.0, 0.0, 1.0])


def ground_plane(ground: bpy.types.Object) -> Plane:
    """A point and the normal of the top of an object's box, as seen along its own Z axis."""
    corners = np.array([tuple(corner) for corner in ground.bound_box])
    matrix = evaluated.matrix(ground)
    top = corners.mean(axis=0)
    top[2] = corners[:, 2].max()
    normal = np.cross(matrix[:3, 0], matrix[:3, 1])
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        raise problem.Problem(problem.flat_object(ground.name))
    return matrix[:3, :3] @ top + matrix[:3, 3], normal / length
