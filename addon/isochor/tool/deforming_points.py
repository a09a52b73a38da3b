# SPDX-License-Identifier: GPL-3.0-or-later
"""Deforms the control points of surfaces, curves and lattices by a lattice, once or frame by frame."""

from collections.abc import Generator
from contextlib import ExitStack
from dataclasses import dataclass

import bpy
import numpy as np

from ..core import grid, problem
from ..core.point_deformer import Deformed, deform
from ..core.settings import Settings
from ..core.shell import Shell, shell
from ..core.words import Sentence, named
from . import absolute_keys, control_points, evaluated, frames, point_rest

Array = control_points.Array


@dataclass(frozen=True)
class Deformer:
    """The lattice that deforms, and how."""

    lattice: bpy.types.Object
    settings: Settings


def refuse(obj: bpy.types.Object, deformer: Deformer, anew: bool) -> None:
    """Raises ``Problem`` where the points of an object cannot be deformed."""
    if not obj.is_editable or obj.override_library is not None:
        raise problem.Problem(problem.foreign(obj.name))
    if obj.mode == "EDIT":
        raise problem.Problem(problem.in_edit_mode([obj.name]))
    if obj == deformer.lattice:
        raise problem.Problem(
            Sentence("“{name}” cannot deform itself: select what it is to deform, and it last.", name=obj.name)
        )
    if point_rest.is_edited(obj) and not anew:
        raise problem.Problem(
            Sentence(
                "The points of “{name}” were edited after they had been deformed: Restore Points first to edit those at"
                " rest, or turn on From Here to deform them as they stand.",
                name=obj.name,
            )
        )
    rest = point_rest.rest_of(obj)
    if rest.shape_keys is not None and not rest.is_editable:
        raise problem.Problem(problem.foreign(rest.name))


def deform_now(
    objects: list[bpy.types.Object], deformer: Deformer, anew: bool, context: bpy.types.Context
) -> list[tuple[bpy.types.Object, Deformed]]:
    """Has each object show its points deformed, from those at rest, or with ``anew`` from those that it shows. Raises
    ``Problem``, with nothing changed."""
    for obj in objects:
        refuse(obj, deformer, anew)
    found = []
    with ExitStack() as undo:
        before = [None if anew else point_rest.restore(obj) for obj in objects]
        for obj, shown in zip(objects, before, strict=True):
            undo.callback(point_rest.put_back, obj, shown)
        context.view_layer.update()
        depsgraph = context.evaluated_depsgraph_get()
        for obj in objects:
            points = point_rest.shape_now(obj)
            found.append((obj, deformed(obj, points, shell_of(obj, points), deformer, depsgraph)))
        undo.pop_all()
    for (obj, one), shown in zip(found, before, strict=True):
        if anew:
            point_rest.take_as_rest(obj)
        point_rest.show(obj, one.points)
        point_rest.remove(shown)
    return found


def bake(
    objects: list[bpy.types.Object], deformer: Deformer, span: tuple[int, int], context: bpy.types.Context
) -> Generator[frames.Step, None, list[str]]:
    """Has each object play its points deformed frame by frame, from those at rest, as absolute shape keys; returns
    warnings in plain words. Nothing changes where the iterator is closed before its end, or raises Problem."""
    for obj in objects:
        refuse(obj, deformer, anew=False)
    when = frames.moments(*span)
    shapes: list[list[Array]] = [[] for _ in objects]
    warnings: dict[str, None] = {}
    with frames.frame_kept(context.scene), ExitStack() as undo:
        before = [point_rest.restore(obj) for obj in objects]
        for obj, shown in zip(objects, before, strict=True):
            undo.callback(point_rest.put_back, obj, shown)
        shells: dict[bpy.types.Object, Shell | None] = {}
        for done, moment in enumerate(when, 1):
            context.scene.frame_set(moment.frame)
            depsgraph = context.evaluated_depsgraph_get()
            for obj, record in zip(objects, shapes, strict=True):
                points = point_rest.shape_now(obj)
                shells.setdefault(obj, shell_of(obj, points))
                found = deformed(obj, points, shells[obj], deformer, depsgraph)
                record.append(found.points)
                if found.trouble:
                    warnings[named(obj.name, found.trouble)] = None
            yield frames.Step(done, len(when), moment)
        for obj, record, shown in zip(objects, shapes, before, strict=True):
            _play(obj, span[0], record)
            point_rest.remove(shown)
        undo.pop_all()
    return list(warnings)


def shell_of(obj: bpy.types.Object, points: Array) -> Shell | None:
    """The surface over the control points, or None where the object has none."""
    return shell(control_points.patches(obj.data), points) if obj.type == "SURFACE" else None


def _play(obj: bpy.types.Object, first: int, shapes: list[Array]) -> None:
    point_rest.prepare_for_keys(obj)
    absolute_keys.add(
        obj, first, len(shapes), lambda key, number: control_points.write_key(obj.data, key, shapes[number])
    )


def deformed(
    obj: bpy.types.Object, points: Array, surface: Shell | None, deformer: Deformer, depsgraph: bpy.types.Depsgraph
) -> Deformed:
    """What the lattice, as it stands in this evaluation, makes of the points."""
    if not len(points):
        raise problem.Problem(problem.NO_POINTS)
    held, shown = deformer.lattice.evaluated_get(depsgraph), obj.evaluated_get(depsgraph)
    for one in (held, shown):
        if not one.is_evaluated:
            raise problem.Problem(problem.not_shown(one.name))
    settings = deformer.settings
    lattice_points = evaluated.lattice_points(held)
    object_matrix = evaluated.matrix(shown)
    transform = grid.relative_transform(object_matrix, evaluated.matrix(held), (obj.name, held.name))
    interpolation = evaluated.interpolation(held) if settings.basis == "Blender" else None
    shape, low, high = lattice_points.shape, lattice_points.low, lattice_points.high
    rest_grid = grid.Grid(shape, low, high, settings.basis, transform, interpolation)
    control = grid.control_points(rest_grid, lattice_points.deformed)
    frame = grid.correction_frame(settings.space, object_matrix, transform)
    return deform(np.asarray(points, np.float64), surface, rest_grid, control, settings, frame)
