# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes to Blender's own Lattice modifier with the corrected control points, wherever it holds the very same map."""

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core import grid, native_lattice, problem
from ..core.arrays import same_array
from ..core.grid import Grid
from ..core.request import Request
from ..core.tally import Tally
from ..core.words import Sentence, sentence, together
from . import (
    adding,
    animation_paths,
    baked,
    evaluated,
    frame_keys,
    frames,
    influence_group,
    lattice_weights,
    linear_curve,
    sockets,
    stack,
    state,
)

NAME = "Volume Lattice Points"
Array = NDArray[np.float64]


@dataclass
class Record:
    """What was read of one object, frame by frame. ``follows``: whether the way from lattice to object changes, so that
    the new lattice has to follow the animator's instead of the object. ``inside``: (V,) which vertices move, where
    some are outside the lattice and stay; None where all move."""

    first: Request
    inside: NDArray[np.bool_] | None
    follows: bool = False
    to_object: list[Array] = field(default_factory=list)
    control: list[Array] = field(default_factory=list)
    strength: list[float] = field(default_factory=list)


def bake(
    context: bpy.types.Context, chosen: list[frames.Target], frame_start: int, frame_end: int
) -> Generator[frames.Step, None, list[str]]:
    """Makes a lattice and a Lattice modifier for each object and switches ours off; returns warnings in plain words.
    Nothing changes where the iterator is closed before its end, or raises Problem."""
    for target in chosen:
        text = _refusal_of_several(target)
        if text:
            raise problem.Problem(text)
    when = frames.moments(frame_start, frame_end)
    records: dict[str, Record] = {}
    tally = Tally()
    with closing(frames.walk(context, chosen, when)) as steps:
        for done, moment in enumerate(steps, 1):
            for target in chosen:
                _note(records, target, moment, context)
                tally.add(target.obj.name, moment.words, target.problems())
            yield frames.Step(done, len(when), moment)
    for target in chosen:
        _play(target, [float(moment.frame) for moment in when], records[target.obj.name])
    return list(tally.lines)


def _refusal_of_several(target: frames.Target) -> str | None:
    if len(target.ours) == 1:
        return None
    return Sentence(
        "“{name}” has {count} Volume Lattices, and one lattice cannot stand for them: switch all but one off for"
        " renders, or bake to a point cache.",
        name=target.obj.name,
        count=len(target.ours),
    )


def refusal(obj: bpy.types.Object, request: Request, outside: int) -> str | None:
    """Why Blender's Lattice modifier cannot do what ours did to the object in one frame, with so many vertices outside
    the lattice; or None."""
    if request.bound is not None and request.bound.is_shaped:
        return Sentence(
            "the lattice of “{name}” was already shaped when its rest was set: Blender's own Lattice modifier cannot"
            " hold that. Bake to a point cache instead.",
            name=obj.name,
        )
    if request.embedding_grid.weights is not None:
        return Sentence(
            "the points of the lattice of “{name}” have weights, which Blender's own Lattice modifier does not know:"
            " bake to a point cache instead.",
            name=obj.name,
        )
    axes = native_lattice.native_axes(request.embedding_grid)
    if not axes:
        points = " × ".join(map(str, request.embedding_grid.shape))
        return Sentence(
            "the lattice of “{name}” has {points} points: Blender's own Lattice modifier goes up to 4 on each side with"
            " the Bernstein basis. Bake to a point cache instead.",
            name=obj.name,
            points=points,
        )
    if request.settings.outside == "Extend":
        held = all(axis.follows_nearest for axis in axes)
    else:
        held = obj.data.is_editable and len(request.positions) == len(obj.data.vertices)
    if outside and not held:
        return Sentence(
            "{outside} vertices of “{name}” are outside the lattice, where Blender's own Lattice modifier moves them"
            " otherwise: make the lattice larger, or bake to a point cache.",
            outside=outside,
            name=obj.name,
        )
    return None


def _note(records: dict[str, Record], target: frames.Target, moment: frames.Moment, context: bpy.types.Context) -> None:
    memory = state.recall(target.obj, target.last)
    request = None if memory is None else memory.asked
    if memory is None or request is None or memory.report.control is None:
        raise problem.Problem(
            Sentence(
                "Frame {frame}, “{name}”: {problems}",
                frame=moment.words,
                name=target.obj.name,
                problems=together(target.problems()),
            )
        )
    outside = memory.report.vertices_outside or 0
    inside = None
    if outside and request.settings.outside == "Keep":
        inside = native_lattice.inside(request.embedding_grid, request.positions)
    text = refusal(target.obj, request, outside)
    record = records.setdefault(target.obj.name, Record(request, inside))
    text = text or _change(record, request, inside, target.obj.name)
    if text:
        raise problem.Problem(Sentence("Frame {frame}: {problem}", frame=moment.words, problem=sentence(text)))
    here = request.embedding_grid
    record.follows = record.follows or not _same_place(record.first.embedding_grid, here, target, context)
    record.to_object.append(here.to_object)
    record.control.append(np.array(memory.report.control))
    record.strength.append(request.settings.strength)


def _change(record: Record, request: Request, inside: NDArray[np.bool_] | None, name: str) -> str | None:
    """What is not as in the first frame and has to be, for one new lattice and modifier to hold both; or None."""

    def kind(request: Request) -> tuple[object, ...]:
        rest, settings = request.embedding_grid, request.settings
        box = rest.shape, rest.low, rest.high, rest.basis, rest.interpolation
        return *box, settings.vertex_group, settings.invert, settings.outside

    if kind(record.first) != kind(request):
        return Sentence("the lattice's resolution or the inputs of “{name}” change: bake to a point cache.", name=name)
    if not same_array(record.inside, inside):
        return Sentence(
            "other vertices of “{name}” are outside the lattice than before: make it larger, or bake to a point cache.",
            name=name,
        )
    return None


def _same_place(one: Grid, other: Grid, target: frames.Target, context: bpy.types.Context) -> bool:
    """Whether the lattice stands to the object as it did, but for the rounding of Blender's matrices."""
    depsgraph = context.view_layer.depsgraph
    lattice = sockets.read(target.last, sockets.LATTICE)
    matrices = [evaluated.matrix(obj.evaluated_get(depsgraph)) for obj in (target.obj, lattice)]
    return grid.steadied(other.to_object, one.to_object, *matrices) is one.to_object


def _play(target: frames.Target, when: list[float], record: Record) -> None:
    """Puts the Lattice modifier right behind ours."""
    obj, request = target.obj, record.first
    axes = native_lattice.native_axes(request.embedding_grid)
    baked.drop(obj)
    lattice = _new_lattice(obj, axes)
    placement = native_lattice.placement(axes)
    if record.follows:
        _attach(lattice, sockets.read(target.last, sockets.LATTICE), placement)
    else:
        record.to_object = [record.to_object[0]] * len(when)
        _attach(lattice, obj, record.to_object[0] @ placement)
    points = [
        native_lattice.native_points(axes, control, to_object @ placement).astype(np.float32)
        for control, to_object in zip(record.control, record.to_object, strict=True)
    ]
    frame_keys.add(lattice, "Frame", when, points)
    if request.settings.basis == "Blender":
        lattice_weights.copy_own_group(sockets.read(target.last, sockets.LATTICE), lattice)
    modifier = obj.modifiers.new(NAME, "LATTICE")
    modifier.object = lattice
    _set_strength(modifier, when, record.strength)
    modifier.vertex_group, modifier.invert_vertex_group = influence_group.of(obj, request.settings, record.inside)
    stack.move_behind(modifier, target.last)
    baked.switch_over(obj, modifier, ("viewport", "render"))


def _new_lattice(obj: bpy.types.Object, axes: native_lattice.Axes) -> bpy.types.Object:
    """A hidden lattice object, in the collections of the object that it is to shape."""
    data = bpy.data.lattices.new(f"{obj.name} {NAME}")
    lattice = bpy.data.objects.new(data.name, data)
    lattice[baked.MADE_BY_BAKE] = True
    # Only now that an object has it does Blender keep the lattice's size when the resolution changes.
    for axis, native in zip("uvw", axes, strict=True):
        setattr(data, f"points_{axis}", native.count)
        setattr(data, f"interpolation_type_{axis}", native.interpolation)
    open_ones = [collection for collection in obj.users_collection if adding.takes_objects(collection)]
    for collection in open_ones or [bpy.context.scene.collection]:
        collection.objects.link(lattice)
    lattice.hide_viewport = True
    return lattice


def _attach(lattice: bpy.types.Object, parent: bpy.types.Object, to_parent: Array) -> None:
    """Has the lattice follow ``parent``; as a parent's inverse, the matrix may shear."""
    lattice.parent = parent
    lattice.matrix_parent_inverse = Matrix(to_parent.tolist())


def _set_strength(modifier: bpy.types.LatticeModifier, when: list[float], strength: list[float]) -> None:
    modifier.strength = strength[0]
    if any(value != strength[0] for value in strength):
        path = f"{animation_paths.of_modifier(modifier)}.strength"
        linear_curve.add(modifier.id_data, path, when, strength)
