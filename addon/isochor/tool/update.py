# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes one object's Volume Lattice modifiers from one evaluated depsgraph and writes their result meshes."""

from collections import Counter
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import grid, problem, shaping
from ..core.bodies import Bodies
from ..core.report import Report
from ..core.request import Request, Vertices
from ..core.settings import Settings
from ..core.solver import Outcome
from . import (
    chain,
    correction_inputs,
    device,
    evaluated,
    frame_memory,
    incoming_nodes,
    rest_volumes,
    results,
    sockets,
    stack,
)
from .entered import Entered
from .job import Job, Key, Memory


def update_object(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, edits: Counter[int], memories: dict[Key, Memory]
) -> list[Memory]:
    """Computes all of the object's modifiers that are on, each fed the fresh result of the one before, and writes
    what has changed. ``edits``: of each mesh and lattice, by session identifier, how often it was edited. Returns the
    memories touched, reports in them."""
    obj_evaluated = obj.evaluated_get(depsgraph)
    if not obj_evaluated.is_evaluated or (obj_evaluated.type == "MESH" and obj_evaluated.data.is_editmode):
        return []
    modifiers = stack.active(obj, depsgraph.mode)
    touched = []
    before: chain.Chain | None = None
    for place, modifier in enumerate(modifiers):
        if not stack.is_ours(modifier):
            continue
        followed = bool(stack.following(modifiers, modifier))
        entered = Entered(obj_evaluated, str(modifier.persistent_uid), followed)
        chained = place > 0 and stack.is_ours(modifiers[place - 1])
        job = Job(obj, obj_evaluated, modifier, depsgraph, edits, entered, before if chained else None)
        if sockets.read(job.evaluated_modifier, sockets.SLOT) != job.slot:
            continue
        if job.key not in memories:
            memories[job.key] = Memory(frame_memory.solver(job.mode))
        memory = memories[job.key]
        before = _update_modifier(job, memory, modifiers)
        touched.append(memory)
    return touched


def _update_modifier(job: Job, memory: Memory, modifiers: list[bpy.types.Modifier]) -> chain.Chain | None:
    """Computes and writes one modifier; the chain up to it, or None where it cannot be known what leaves it."""
    entered = memory.asked = None
    problems: list[str] = []
    result = results.of(job.modifier, job.mode)
    try:
        if result is not None and not result.is_editable:
            raise problem.Problem(problem.linked(job.obj.name))
        entered = _entered(job, memory, modifiers)
        settings = sockets.read_settings(job.evaluated_modifier)
        memory.bound.look_at(result)
        request, problems = _request(job, memory, modifiers, entered, settings)
        problems += _edited(job, memory, result, settings)
        memory.asked = rest_volumes.known(job, request, memory.solver, result)
        outcome = memory.solver.solve(memory.asked)
    except problem.Problem as trouble:
        outcome = Outcome(None, Report(problems=(trouble.sentence,)))
    memory.report = outcome.report
    if problems:
        # The solver hands out the same outcome again: what surrounds it must not be written into it.
        memory.report = replace(outcome.report, problems=tuple(dict.fromkeys((*problems, *outcome.report.problems))))
    if result is not None and result.is_editable and outcome is not memory.written:
        if outcome.vertices is not None or len(result.data.vertices):
            results.write(result, outcome.vertices)
        memory.written = outcome
    leaving = entered if outcome.vertices is None else outcome.vertices
    return chain.longer(job.before, job.modifier, entered, leaving, outcome.report.keeps_volume)


def _entered(job: Job, memory: Memory, modifiers: list[bpy.types.Modifier]) -> Vertices:
    """(V, 3) positions that entered the modifier, in object space."""
    if job.before is not None:
        return job.before.leaving
    is_mesh = job.obj.type == "MESH" and job.obj.data.shape_keys is None
    if is_mesh and modifiers[0] == job.modifier and job.obj.mode == "OBJECT":
        positions = _own_positions(job, memory)
    else:
        found = job.entered.positions
        positions = np.empty((0, 3), np.float32) if found is None else found
        if found is None and not job.entered.is_empty:
            after = stack.following(modifiers, job.modifier)
            raise problem.Problem(problem.lost_by([modifier.name for modifier in after]))
    if len(positions) == 0:
        raise problem.Problem(problem.NO_VERTICES)
    return positions


def _own_positions(job: Job, memory: Memory) -> Vertices:
    """Those of the object's own mesh, which enter where nothing comes before; read again only after an edit."""
    stamp = (job.obj.data.session_uid, job.mesh_edits)
    if memory.own_positions is None or stamp != memory.own_stamp:
        positions = evaluated.attribute(job.obj.data, "position", "vector", 3, np.float32)
        memory.own_positions = np.empty((0, 3), np.float32) if positions is None else positions.reshape(-1, 3)
        memory.own_stamp = stamp
    return memory.own_positions


def _request(
    job: Job,
    memory: Memory,
    modifiers: list[bpy.types.Modifier],
    positions: Vertices,
    settings: Settings,
) -> tuple[Request, list[str]]:
    lattice = _lattice(job)
    points = evaluated.lattice_points(lattice, memory.lattice_boxes.get(lattice.session_uid, evaluated.UNIT_BOX))
    memory.lattice_boxes[lattice.session_uid] = points.box
    memory.bound.refuse_other(lattice.name, points.shape)
    bound = memory.bound.embedding(settings.basis)
    object_matrix, lattice_matrix = evaluated.matrix(job.obj_evaluated), evaluated.matrix(lattice)
    names = (job.obj.name, lattice.name)
    steady = memory.transform_before if bound is None else bound.grid.to_object
    transform = memory.placing.of(object_matrix, lattice_matrix, names)
    transform = grid.steadied(transform, steady, object_matrix, lattice_matrix)
    rest_grid = grid.Grid(points.shape, points.low, points.high, settings.basis, transform)
    influence, problems = _influence(job, settings, len(positions))
    triangles, no_triangles = _triangles(job, memory, modifiers, len(positions))
    bodies, region_problems = correction_inputs.bodies(job, memory, settings, triangles, len(positions))
    stiffness, stiffness_problems = correction_inputs.stiffness(job, memory, settings, lattice)
    frame, frame_problems = correction_inputs.frame(job, settings, object_matrix, transform)
    pins, pin_problems = correction_inputs.pins(job, memory, modifiers, positions, triangles)
    problems += [*region_problems, *stiffness_problems, *frame_problems, *pin_problems]
    if triangles is None and not no_triangles:
        settings = replace(settings, preserve=0.0)
    request = Request(
        positions=positions,
        influence=influence,
        triangles=triangles,
        no_triangles=no_triangles,
        grid=rest_grid,
        control=grid.control_points(rest_grid, _shaped(memory, rest_grid, points, lattice_matrix, settings)),
        frame=frame,
        rest_volume=None,
        incoming=_incoming(job, settings, triangles, bodies),
        settings=settings,
        device=device.chosen(),
        double=device.is_double(),
        bound=bound,
        bodies=bodies,
        stiffness=stiffness,
        pins=pins,
    )
    return request, [*problems, *_between(modifiers, job.modifier)]


def _incoming(
    job: Job, settings: Settings, triangles: NDArray[np.int32] | None, bodies: Bodies | None
) -> tuple[float, ...] | None:
    """The volumes that Reference Incoming means, where they are not those of what enters the modifier itself."""
    if job.before is None or settings.reference != "Incoming" or settings.preserve <= 0.0:
        return None
    return job.before.incoming(triangles, bodies)


def _shaped(
    memory: Memory,
    rest_grid: grid.Grid,
    points: evaluated.LatticePoints,
    lattice_matrix: NDArray[np.float64],
    settings: Settings,
) -> NDArray[Any]:
    """The lattice's points, flat in lattice space, as the inputs of the panel Animate move them."""
    if settings.shaping.is_neutral:
        return points.deformed
    memory.metric = shaping.metric(lattice_matrix, settings.shaping.axis, memory.metric)
    return shaping.shaped(points.deformed, rest_grid, memory.metric, settings.shaping)


def _lattice(job: Job) -> bpy.types.Object:
    """The evaluated lattice object."""
    lattice = sockets.read(job.modifier, sockets.LATTICE)
    if lattice is None:
        raise problem.Problem(problem.NO_LATTICE)
    if lattice.type != "LATTICE":
        raise problem.Problem(problem.not_a_lattice(lattice.name, lattice.type))
    return lattice.evaluated_get(job.depsgraph)


def _influence(job: Job, settings: Settings, count: int) -> tuple[NDArray[np.float32] | None, list[str]]:
    """(V,) in [0, 1], or None for 1 everywhere, and what is wrong with the vertex group."""
    problems: list[str] = []
    mask = None
    if settings.vertex_group:
        if job.entered.has_group(job.obj, settings.vertex_group):
            mask = job.entered.numbers(incoming_nodes.MASK)
        else:
            problems.append(problem.no_vertex_group(settings.vertex_group))
    if mask is None:
        everywhere = settings.strength >= 1.0
        return (None if everywhere else np.full(count, settings.strength, np.float32)), problems
    return np.clip(mask[:count] * np.float32(settings.strength), 0.0, 1.0), problems


def _triangles(
    job: Job, memory: Memory, modifiers: list[bpy.types.Modifier], count: int
) -> tuple[NDArray[np.int32] | None, str]:
    """Triangles of what entered, or None and the reason in plain words, which is empty where that has no surface."""
    mesh, own = job.entered.mesh, None
    if mesh is None:
        return None, ""
    stamp = None
    if job.obj.type == "MESH":
        own, stamp = job.obj.data, stack.face_stamp(modifiers)
    if stamp is not None:
        stamp = (job.obj.data.session_uid, job.mesh_edits, *stamp)
    triangles = memory.faces.read(mesh, own, count - job.entered.others, stamp)
    if triangles is None:
        others = [*stack.preceding(modifiers, job.modifier), *stack.following(modifiers, job.modifier)]
        return None, problem.faces_hidden_by([modifier.name for modifier in others])
    return (triangles, "") if len(triangles) else (None, problem.NO_FACES)


def _edited(job: Job, memory: Memory, result: bpy.types.Object | None, settings: Settings) -> list[str]:
    """The problem of a mesh that was edited since its rest volume was kept; looked at only after an edit."""
    key = results.REST_OWN_VOLUME if job.obj.type == "MESH" else results.REST_COUNT
    kept = None if result is None else result.get(key)
    if result is None or kept is None or settings.reference != "Rest":
        return []
    stamp = (job.obj.data.session_uid, job.mesh_edits, kept)
    if job.obj.mode == "OBJECT" and stamp != memory.edited_stamp:
        memory.edited, memory.edited_stamp = results.is_edited(result, job.obj), stamp
    return [problem.EDITED] if memory.edited else []


def _between(modifiers: list[bpy.types.Modifier], modifier: bpy.types.Modifier) -> list[str]:
    """The problem of others that stand between the one of ours before and this one."""
    place = modifiers.index(modifier)
    before = [index for index in range(place) if stack.is_ours(modifiers[index])]
    if not before or before[-1] == place - 1:
        return []
    return [problem.between([other.name for other in modifiers[before[-1] + 1 : place]])]
