# SPDX-License-Identifier: GPL-3.0-or-later
"""The volumes at rest that a file keeps on result objects, noted when they are first asked for. Lattices in a chain
have one: that of what entered the first."""

from dataclasses import replace

import bpy

from ..core.request import Request
from ..core.solver import Solver
from . import results, stack
from .job import Job


def known(job: Job, request: Request, solver: Solver, result: bpy.types.Object | None) -> Request:
    """The request with the volumes kept in the file; where none are kept yet, those of what enters now are."""
    if result is None:
        return request
    bodies = request.bodies
    if bodies is None:
        volume = result.get(results.REST_VOLUME)
        volume = _whole(job, request, solver) if volume is None else volume
        return replace(request, rest_volume=volume)
    request = replace(request, rest_volume=result.get(results.REST_VOLUME))
    stamp = bodies.stamp(len(request.positions))
    parts = results.kept_parts(result, stamp)
    return replace(request, rest_parts=parts) if parts else _with_parts(job, request, solver, stamp)


def _whole(job: Job, request: Request, solver: Solver) -> float | None:
    known = (source.get(results.REST_VOLUME) for source in _sources(job))
    volume = next((kept for kept in known if kept is not None), None)
    volume = solver.whole_volume(_at_start(job, request)) if volume is None else volume
    if volume is not None:
        for result in _keepers(job.obj, job.modifier, job.mode, results.REST_VOLUME):
            results.keep_rest(result, volume, job.obj)
    return volume


def _sources(job: Job) -> list[bpy.types.Object]:
    """Other results that know the same volume: in a render the viewport's, and that of the lattice before."""
    shown = _shown(job.obj, job.modifier) if job.mode == "RENDER" else None
    before = None if job.before is None else job.before.kept(job.mode)
    return [result for result in (shown, before) if result is not None]


def _at_start(job: Job, request: Request) -> Request:
    """The same mesh as it entered the first of the lattices right before this one."""
    return request if job.before is None else replace(request, positions=job.before.entered)


def _with_parts(job: Job, request: Request, solver: Solver, stamp: str) -> Request:
    whole = request.rest_volume
    if whole is None:
        whole = _whole(job, request, solver)
        request = replace(request, rest_volume=whole)
    known = (results.kept_parts(source, stamp) for source in _sources(job))
    parts = next((kept for kept in known if kept), None) or solver.incoming_parts(_at_start(job, request))
    if parts:
        for result in _keepers(job.obj, job.modifier, job.mode, ""):
            results.keep_parts(result, stamp, parts, job.obj)
    return replace(request, rest_parts=parts)


def _shown(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The viewport's result object, where what enters in a render is the same mesh."""
    return None if stack.differing_before(obj, modifier) else results.of(modifier, "VIEWPORT")


def _keepers(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str, unless: str
) -> list[bpy.types.Object]:
    """The result objects to note a volume on: of this mode, and of the viewport's the render's too where the same mesh
    enters and it lacks the property ``unless``, so that every process that renders the file has it. Where another
    enters, it is measured on saving: settings must not change here."""
    found = [results.of(modifier, mode)]
    rendered = results.of(modifier, "RENDER")
    if mode != "RENDER" and rendered is not None and unless not in rendered:
        found += [] if stack.differing_before(obj, modifier) else [rendered]
    return [result for result in found if result is not None]
