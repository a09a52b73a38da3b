# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the shape that a Volume Lattice shows the mesh's own, or a shape key of it, and takes the modifier away."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.words import Sentence, named, together
from . import baked, removing, stack, state

Shape = NDArray[np.float32]
Pair = tuple[bpy.types.Object, bpy.types.NodesModifier]


@dataclass(frozen=True)
class How:
    """What applying is asked to do. ``keep_modifier`` matters for shape keys only."""

    as_shape_key: bool = False
    keep_modifier: bool = False
    single_user: bool = False


def apply(pairs: list[Pair], how: How, context: bpy.types.Context) -> list[str]:
    """Applies each modifier, of one object in stack order; returns warnings in plain words.

    Raises Problem, with nothing changed, where one of them cannot be.
    """
    pairs = sorted(pairs, key=lambda pair: list(pair[0].modifiers).index(pair[1]))
    for obj, modifier in pairs:
        text = _refusal(obj, modifier, how)
        if text:
            raise problem.Problem(text)
    _evaluate([obj for obj, _ in pairs], context)
    for obj, modifier in pairs:
        _shown(obj, modifier, context)
    chosen = [modifier for _, modifier in pairs]
    found = [_made_alone(obj, modifier, chosen, context) for obj, modifier in pairs]
    for (obj, modifier), (shape, _warnings) in zip(pairs, found, strict=True):
        _take(obj, modifier, shape, how)
    return [text for _shape, warnings in found for text in warnings]


def shared(obj: bpy.types.Object) -> bool:
    """Whether another object uses the mesh as well."""
    mesh = obj.data
    return bool(mesh.users - mesh.use_fake_user > 1)


def _refusal(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, how: How) -> str | None:
    """What of the object's state stands against it."""
    if obj.type != "MESH":
        return problem.only_meshes(obj.name, obj.type)
    if not obj.is_editable:
        return problem.linked(obj.name)
    if obj.override_library is not None and modifier.is_override_data:
        return Sentence(
            "“{modifier}” of “{name}” belongs to the object's library: make the object local first.",
            modifier=modifier.name,
            name=obj.name,
        )
    if obj.mode != "OBJECT":
        return Sentence("“{name}” is in another mode: go to Object Mode first.", name=obj.name)
    if baked.is_playing(obj):
        return problem.plays_bake(obj.name)
    if not modifier.show_viewport:
        return Sentence(
            "“{modifier}” of “{name}” is switched off: switch it on in the viewport first.",
            modifier=modifier.name,
            name=obj.name,
        )
    return _mesh_refusal(obj, how)


def _mesh_refusal(obj: bpy.types.Object, how: How) -> str | None:
    mesh, name = obj.data, obj.name
    if shared(obj) and not how.single_user:
        return Sentence(
            "Other objects use the mesh of “{name}” too: turn Single User on to give it a mesh of its own.", name=name
        )
    if not mesh.is_editable and not how.single_user:
        return Sentence(
            "The mesh of “{name}” comes from another file: turn Single User on to give it a mesh of its own.", name=name
        )
    if mesh.shape_keys is None:
        return None
    if not how.as_shape_key:
        return Sentence(
            "“{name}” has shape keys, which a new shape would contradict: apply as shape key, or remove them first.",
            name=name,
        )
    if not mesh.shape_keys.use_relative:
        return problem.absolute_keys(name)
    if obj.show_only_shape_key:
        return problem.solo_key(name)
    return None


def _evaluate(objects: list[bpy.types.Object], context: bpy.types.Context) -> None:
    """Has everything computed from how the file stands now."""
    for obj in objects:
        obj.update_tag(refresh={"DATA"})
    context.view_layer.update()


def _shown(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, context: bpy.types.Context) -> Shape:
    """(V, 3) vertices that left the modifier when it was evaluated last, as many as the mesh has."""
    memory = state.recall(obj, modifier)
    if not obj.evaluated_get(context.view_layer.depsgraph).is_evaluated or memory is None or memory.written is None:
        raise problem.Problem(problem.not_shown(obj.name))
    if memory.written.vertices is None:
        raise problem.Problem(
            Sentence(
                "There is nothing to apply on “{name}”. {problems}",
                name=obj.name,
                problems=together(memory.report.problems),
            )
        )
    if len(memory.written.vertices) != len(obj.data.vertices):
        before = [other.name for other in _on_before(obj, modifier)]
        raise problem.Problem(
            Sentence(
                "{others} of “{name}” makes vertices that its mesh does not have: apply that first, or move"
                " “{modifier}” above it.",
                others=", ".join(before),
                name=obj.name,
                modifier=modifier.name,
            )
        )
    return np.asarray(memory.written.vertices, np.float32)


def _made_alone(
    obj: bpy.types.Object,
    modifier: bpy.types.NodesModifier,
    chosen: list[bpy.types.NodesModifier],
    context: bpy.types.Context,
) -> tuple[Shape, list[str]]:
    """The shape that the modifier makes of the object's mesh, without the modifiers before it that stay, as Blender
    applies a modifier that is not the first; and warnings."""
    before = [other for other in _on_before(obj, modifier) if other not in chosen]
    with _switched_off(before):
        _evaluate([obj], context)
        shape = _shown(obj, modifier, context)
        memory = state.recall(obj, modifier)
    warnings: list[str] = [] if memory is None else [named(obj.name, text) for text in memory.report.problems]
    if before:
        names = ", ".join(other.name for other in before)
        warnings.append(
            Sentence(
                "{name}: {others} comes before {modifier}, which was applied without it: the result may differ",
                name=obj.name,
                others=names,
                modifier=modifier.name,
            )
        )
    return shape, warnings


def _take(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, shape: Shape, how: How) -> None:
    """Gives the shape to the mesh, its own from now on, and takes the modifier away."""
    if not obj.data.is_editable or shared(obj):
        obj.data = obj.data.copy()
    if how.as_shape_key:
        _add_key(obj, modifier.name, shape)
    else:
        obj.data.attributes["position"].data.foreach_set("vector", shape.reshape(-1))
        obj.data.update()
    if how.as_shape_key and how.keep_modifier:
        modifier.show_viewport = modifier.show_render = False
    else:
        removing.remove(obj, modifier)


def _on_before(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[bpy.types.Modifier]:
    active = stack.active(obj, "VIEWPORT")
    return active[: active.index(modifier)]


@contextmanager
def _switched_off(modifiers: list[bpy.types.Modifier]) -> Iterator[None]:
    for modifier in modifiers:
        modifier.show_viewport = False
    try:
        yield
    finally:
        for modifier in modifiers:
            modifier.show_viewport = True


def _add_key(obj: bpy.types.Object, name: str, shape: Shape) -> None:
    """A relative key that, at 1, makes this shape of what the other keys make now."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    block = obj.shape_key_add(name=name, from_mix=True)
    mixed, basis = _coordinates(block), _coordinates(obj.data.shape_keys.reference_key)
    wanted = shape.astype(np.float64) - mixed + basis
    block.points.foreach_set("co", wanted.astype(np.float32).reshape(-1))
    block.relative_key = obj.data.shape_keys.reference_key
    block.value = 1.0


def _coordinates(block: bpy.types.ShapeKey) -> NDArray[np.float64]:
    found = np.empty(len(block.points) * 3, np.float32)
    block.points.foreach_get("co", found)
    return found.reshape(-1, 3).astype(np.float64)
