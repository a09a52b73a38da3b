# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the volume that enters a modifier in a render, where Subdivision may have other levels than the viewport."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from . import results, state

VIEWPORT_OF_RENDER = {"show_render": "show_viewport", "render_levels": "levels"}
"""Settings of a modifier for renders, and those for the viewport that stand in for them while measuring."""


def measure_for_render(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, view_layer: bpy.types.ViewLayer
) -> None:
    """Keeps the rest volume of renders on the modifier's render result. The viewport's must have been kept before."""
    shown, rendered = results.of(modifier, "VIEWPORT"), results.of(modifier, "RENDER")
    if shown is None or rendered is None:
        return
    kept = shown.get(results.REST_VOLUME)
    differing = differing_settings(obj)
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


def differing_settings(obj: bpy.types.Object) -> list[tuple[bpy.types.Modifier, str, str]]:
    """(modifier, viewport setting, render setting) wherever the two have different values."""
    return [
        (modifier, viewport, render)
        for modifier in obj.modifiers
        for render, viewport in VIEWPORT_OF_RENDER.items()
        if hasattr(modifier, render) and getattr(modifier, render) != getattr(modifier, viewport)
    ]


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
