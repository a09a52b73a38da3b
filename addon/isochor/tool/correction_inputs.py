# SPDX-License-Identifier: GPL-3.0-or-later
"""What the inputs of the panel Volume mean in one frame: which parts keep a volume, which points resist, which axes
count. Each function also says what is wrong, in plain words."""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import grid, pin_problem, problem
from ..core.bodies import Bodies
from ..core.pins import Pins
from ..core.request import Vertices
from ..core.settings import Settings
from . import evaluated, incoming_nodes, own_points, sockets, stack
from . import pins as pinned
from .job import Job, Memory


def bodies(
    job: Job, memory: Memory, settings: Settings, triangles: NDArray[np.int32] | None, count: int
) -> tuple[Bodies | None, list[str]]:
    """Which parts keep a volume of their own, or None for one volume of all, and what is wrong with the region."""
    parts = settings.parts
    weights = job.entered.numbers(incoming_nodes.REGION) if parts.region else None
    has_group = bool(parts.region) and job.entered.has_group(job.obj, parts.region)
    return memory.divided.read(has_group, parts, None if weights is None else weights[:count], triangles)


def pins(
    job: Job,
    memory: Memory,
    modifiers: list[bpy.types.Modifier],
    positions: Vertices,
    triangles: NDArray[np.int32] | None,
) -> tuple[Pins | None, list[str]]:
    """The points that objects hold, or None where none does, and what is wrong with others."""
    if pinned.collection(job.modifier) is None:
        return None, []
    if triangles is None and job.obj.type != "MESH":
        return None, [pin_problem.no_surface(job.obj.name)]
    is_own = job.obj.type == "MESH" and stack.keeps_own_vertices(modifiers, job.modifier)
    own_count = own_points.count(job.obj) if is_own else None
    matrix = evaluated.matrix(job.obj_evaluated)
    around = pinned.Around(matrix, job.depsgraph, positions, triangles, own_count)
    return pinned.read(job.modifier, job.mode, around, memory.pinned)


def stiffness(
    job: Job, memory: Memory, settings: Settings, lattice: bpy.types.Object
) -> tuple[NDArray[np.float64] | None, list[str]]:
    """(nu, nv, nw) in [0, 1], or None for 0 everywhere, and what is wrong with the lattice's vertex group."""
    if not settings.stiffness:
        return None, []
    try:
        edits = job.edits[lattice.data.original.session_uid]
        return memory.stiffness.of(lattice, settings.stiffness, edits), []
    except problem.Problem as trouble:
        return None, [trouble.sentence]


def frame(
    job: Job, settings: Settings, object_matrix: NDArray[np.float64], transform: NDArray[np.float64]
) -> tuple[NDArray[np.float64] | None, list[str]]:
    """The directions that Axes means, as ``grid.correction_frame`` gives them, and what is wrong with the object whose
    own they are to be."""
    if settings.space != "Custom":
        return grid.correction_frame(settings.space, object_matrix, transform), []
    chosen = sockets.read(job.modifier, sockets.FRAME)
    own = None if chosen is None else evaluated.matrix(chosen.evaluated_get(job.depsgraph))
    problems = [problem.NO_FRAME] if own is None else []
    if own is not None and abs(np.linalg.det(grid.unit_columns(own))) < 1e-12:
        own, problems = None, [problem.flat_frame(chosen.name)]
    return grid.correction_frame("Custom", object_matrix, transform, own), problems
