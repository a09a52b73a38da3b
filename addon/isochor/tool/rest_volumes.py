# SPDX-License-Identifier: GPL-3.0-or-later
"""The volumes at rest that a file keeps on result objects, noted when they are first asked for."""

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
    obj, modifier, mode = job.obj, job.modifier, job.mode
    bodies = request.bodies
    if bodies is None:
        volume = result.get(results.REST_VOLUME)
        volume = _whole(obj, modifier, mode, request, solver) if volume is None else volume
        return replace(request, rest_volume=volume)
    request = replace(request, rest_volume=result.get(results.REST_VOLUME))
    stamp = bodies.stamp(len(request.positions))
    parts = results.kept_parts(result, stamp)
    return replace(request, rest_parts=parts) if parts else _with_parts(obj, modifier, mode, request, solver, stamp)


def _whole(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str, request: Request, solver: Solver
) -> float | None:
    shown = _shown(obj, modifier) if mode == "RENDER" else None
    kept = None if shown is None else shown.get(results.REST_VOLUME)
    volume = solver.whole_volume(request) if kept is None else kept
    if volume is not None:
        for result in _keepers(obj, modifier, mode, results.REST_VOLUME):
            results.keep_rest(result, volume, obj)
    return volume


def _with_parts(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str, request: Request, solver: Solver, stamp: str
) -> Request:
    whole = request.rest_volume
    if whole is None:
        whole = _whole(obj, modifier, mode, request, solver)
        request = replace(request, rest_volume=whole)
    parts = results.kept_parts(_shown(obj, modifier), stamp) if mode == "RENDER" else None
    parts = parts or solver.incoming_parts(request)
    if parts:
        for result in _keepers(obj, modifier, mode, ""):
            results.keep_parts(result, stamp, parts, obj)
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
