# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the volume that enters a modifier in a render, where Subdivision may have other levels than the viewport."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import bpy

from . import chain, node_group, results, stack, state


def measure_for_render(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, view_layer: bpy.types.ViewLayer
) -> None:
    """Keeps the rest volume of renders on the modifier's render result. The viewport's must have been kept before."""
    shown, rendered = results.of(modifier, "VIEWPORT"), results.of(modifier, "RENDER")
    if shown is None or rendered is None or not _is_kept(shown):
        return
    differing = stack.differing_before(obj, modifier)
    if not differing:
        results.copy_rest(shown, rendered)
        return
    before = chain.previous(obj, modifier)
    known = None if before is None else results.of(before, "RENDER")
    if known is not None and not _lacks(known, shown):
        results.copy_rest(known, rendered)
        return
    with viewport_as_render(differing):
        view_layer.update()
        _keep_entering(obj, modifier, rendered)
    view_layer.update()


def _keep_entering(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, result: bpy.types.Object) -> None:
    """Keeps what entered when the viewport was last evaluated; nothing where that encloses no volume."""
    memory = state.recall(obj, modifier)
    if memory is None or memory.asked is None:
        return
    whole = memory.solver.whole_volume(memory.asked)
    if whole is not None:
        results.keep_rest(result, whole, obj)
    bodies = memory.asked.bodies
    if bodies is not None:
        parts = memory.solver.incoming_parts(replace(memory.asked, rest_volume=whole))
        if parts is not None:
            results.keep_parts(result, bodies.stamp(len(memory.asked.positions)), parts, obj)


def measure_missing(view_layer: bpy.types.ViewLayer) -> None:
    """Keeps the rest volume of renders wherever only the viewport's is kept, as after adding in Edit Mode or copying
    to another mesh. Not for handlers that run while Blender evaluates."""
    for obj in stack.users(node_group.all_groups()):
        if obj.mode != "OBJECT" or not obj.is_editable or obj.name not in view_layer.objects:
            continue
        for modifier in stack.ours(obj):
            shown, rendered = results.of(modifier, "VIEWPORT"), results.of(modifier, "RENDER")
            if shown is not None and rendered is not None and _lacks(rendered, shown):
                measure_for_render(obj, modifier, view_layer)


def _is_kept(result: bpy.types.Object) -> bool:
    return results.REST_VOLUME in result or results.REST_PARTS in result


def _lacks(rendered: bpy.types.Object, shown: bpy.types.Object) -> bool:
    """Whether the viewport's result knows a volume of which the render's knows no counterpart."""
    whole = results.REST_VOLUME in shown and results.REST_VOLUME not in rendered
    return whole or bool(results.kinds_of_parts(shown) - results.kinds_of_parts(rendered))


@contextmanager
def viewport_as_render(differing: list[tuple[bpy.types.Modifier, str, str]]) -> Iterator[None]:
    """Has the viewport evaluate what a render would, and puts everything back."""
    before = [(modifier, viewport, getattr(modifier, viewport)) for modifier, viewport, _render in differing]
    try:
        for modifier, viewport, render in differing:
            setattr(modifier, viewport, getattr(modifier, render))
        yield
    finally:
        for modifier, viewport, value in before:
            setattr(modifier, viewport, value)
