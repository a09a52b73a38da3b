# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the volume that enters a modifier in a render, where Subdivision may have other levels than the viewport."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from . import node_group, results, stack, state


def measure_for_render(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, view_layer: bpy.types.ViewLayer
) -> None:
    """Keeps the rest volume of renders on the modifier's render result. The viewport's must have been kept before."""
    shown, rendered = results.of(modifier, "VIEWPORT"), results.of(modifier, "RENDER")
    if shown is None or rendered is None:
        return
    kept = shown.get(results.REST_VOLUME)
    differing = stack.differing_before(obj, modifier)
    if kept is not None and differing:
        with viewport_as_render(differing):
            view_layer.update()
            kept = entering_volume(obj, modifier)
        view_layer.update()
    if kept is not None:
        results.keep_rest(rendered, kept, obj)


def entering_volume(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> float | None:
    """Signed volume of the mesh that entered when the viewport was last evaluated, or None where it has none."""
    memory = state.recall(obj, modifier)
    return None if memory is None else memory.solver.bound_volume()


def measure_missing(view_layer: bpy.types.ViewLayer) -> None:
    """Keeps the rest volume of renders wherever only the viewport's is kept, as after adding in Edit Mode or copying
    to another mesh. Not for handlers that run while Blender evaluates."""
    for obj in stack.users(node_group.all_groups()):
        if obj.mode != "OBJECT" or not obj.is_editable or obj.name not in view_layer.objects:
            continue
        for modifier in stack.ours(obj):
            shown, rendered = results.of(modifier, "VIEWPORT"), results.of(modifier, "RENDER")
            known = shown is not None and results.REST_VOLUME in shown
            if known and rendered is not None and results.REST_VOLUME not in rendered:
                measure_for_render(obj, modifier, view_layer)


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
