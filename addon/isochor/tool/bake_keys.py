# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes to shape keys of the mesh: one a frame, exact on the frames and straight between them."""

from collections.abc import Generator
from contextlib import closing

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.tally import Tally
from ..core.words import Sentence
from . import applying, baked, evaluated, frame_keys, frames, stack, state

Shape = NDArray[np.float32]


def bake(
    context: bpy.types.Context, chosen: list[frames.Target], frame_start: int, frame_end: int
) -> Generator[frames.Step, None, list[str]]:
    """Adds the keys to each mesh, on top of what other keys make of it, and switches ours off; returns warnings in
    plain words. Nothing changes where the iterator is closed before its end, or raises Problem."""
    for target in chosen:
        text = _refusal(target)
        if text:
            raise problem.Problem(text)
    when = frames.moments(frame_start, frame_end)
    basis = {target.obj.name: _basis(target.obj) for target in chosen}
    shapes: dict[str, list[Shape]] = {name: [] for name in basis}
    tally = Tally()
    with closing(frames.walk(context, chosen, when)) as steps:
        for done, moment in enumerate(steps, 1):
            for target in chosen:
                name = target.obj.name
                shapes[name].append(_key_shape(target, basis[name], context))
                tally.add(name, moment.words, target.problems())
            yield frames.Step(done, len(when), moment)
    for target in chosen:
        _play(target, [float(moment.frame) for moment in when], shapes[target.obj.name])
    return list(tally.lines)


def _refusal(target: frames.Target) -> str | None:
    """Why the mesh cannot take the keys, or None."""
    obj, mesh = target.obj, target.obj.data
    if not mesh.is_editable:
        return Sentence(
            "The mesh of “{name}” comes from another file, so it takes no shape keys: make it local first.",
            name=obj.name,
        )
    if applying.shared(obj):
        return Sentence(
            "Other objects use the mesh of “{name}” too and would get its shape keys: make it single-user first.",
            name=obj.name,
        )
    before = [modifier.name for modifier in _others_before(target)]
    if before:
        return Sentence(
            "{modifiers} comes before Volume Lattice on “{name}”, but shape keys come before all: apply or remove it,"
            " move Volume Lattice above it, or bake to a point cache.",
            modifiers=", ".join(before),
            name=obj.name,
        )
    return None if mesh.shape_keys is None else _keys_refusal(obj)


def _keys_refusal(obj: bpy.types.Object) -> str | None:
    keys = obj.data.shape_keys
    if not keys.use_relative:
        return problem.absolute_keys(obj.name)
    if obj.show_only_shape_key:
        return problem.solo_key(obj.name)
    action = None if keys.animation_data is None else keys.animation_data.action
    if action is not None and not action.is_editable:
        return Sentence(
            "The animation of the shape keys of “{name}” comes from another file: make it local first.", name=obj.name
        )
    return None


def _others_before(target: frames.Target) -> list[bpy.types.Modifier]:
    """What is on before the last of ours and not ours, nor made by a bake."""
    obj = target.obj
    place = list(obj.modifiers).index(target.last)
    return [
        modifier
        for modifier in obj.modifiers[:place]
        if not stack.is_ours(modifier)
        and (baked.seen_by_renders(obj, modifier) or baked.seen_in_viewport(obj, modifier))
    ]


def _basis(obj: bpy.types.Object) -> Shape:
    """(V, 3) that relative keys are measured from."""
    positions = evaluated.own_shape(obj.data)[0]
    if obj.data.shape_keys is not None:
        obj.data.shape_keys.reference_key.points.foreach_get("co", positions.reshape(-1))
    return positions


def _key_shape(target: frames.Target, basis: Shape, context: bpy.types.Context) -> Shape:
    """(V, 3) of the key that, on top of all others as they are in the frame shown, makes what leaves ours."""
    leaving = frames.leaving(target, context)
    memories = [state.recall(target.obj, modifier) for modifier in target.ours]
    requests = [memory.asked for memory in memories if memory is not None]
    entered = next((request.positions for request in requests if request is not None), leaving)
    return (leaving - entered.astype(np.float64) + basis).astype(np.float32)


def _play(target: frames.Target, when: list[float], shapes: list[Shape]) -> None:
    obj = target.obj
    baked.drop(obj)
    basis_too = obj.data.shape_keys is None
    names = frame_keys.add(obj, target.last.name, when, shapes)
    baked.switch_over(obj, None, ("viewport", "render"), tuple(names), basis_too)
