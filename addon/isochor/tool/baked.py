# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in for our modifiers after a bake: which modifier it is, and how ours were switched before.

Kept as a custom property of the object, so that it goes with the file: the modifiers by their identifiers, which
neither renaming nor moving changes.
"""

from typing import Any

import bpy

from . import stack

KEY = "isochor_bake"
"""Custom property of an object: {"cache": identifier, "viewport" and "render": identifiers of ours that were on}."""


def stand_in(obj: bpy.types.Object) -> bpy.types.Modifier | None:
    """The modifier that plays the bake, or None where there is none (any more)."""
    return None if KEY not in obj else _by_identifier(obj, obj[KEY]["cache"])


def seen_by_renders(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> bool:
    """Whether renders see this modifier where nothing is baked: what a bake switched off counts as on, what it made
    as off."""
    return _seen(obj, modifier, "render", modifier.show_render)


def seen_in_viewport(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> bool:
    """The same for the viewport."""
    return _seen(obj, modifier, "viewport", modifier.show_viewport)


def switch_over(obj: bpy.types.Object, cache: bpy.types.Modifier, modes: tuple[str, ...]) -> None:
    """Has ``cache`` play instead of ours in these modes ("viewport", "render"), and notes how ours were before."""
    note: dict[str, Any] = {"cache": str(cache.persistent_uid)}
    ours = stack.ours(obj)
    for mode, was_on in (("viewport", seen_in_viewport), ("render", seen_by_renders)):
        note[mode] = [str(modifier.persistent_uid) for modifier in ours if was_on(obj, modifier)]
    obj[KEY] = note
    for mode in ("viewport", "render"):
        for modifier in ours:
            on = mode not in modes and str(modifier.persistent_uid) in note[mode]
            setattr(modifier, f"show_{mode}", on)
        setattr(cache, f"show_{mode}", mode in modes)


def switch_back(obj: bpy.types.Object) -> None:
    """Takes the modifier that plays the bake away and switches ours as they were."""
    viewport = {modifier.persistent_uid: seen_in_viewport(obj, modifier) for modifier in stack.ours(obj)}
    render = {modifier.persistent_uid: seen_by_renders(obj, modifier) for modifier in stack.ours(obj)}
    cache = stand_in(obj)
    if cache is not None:
        obj.modifiers.remove(cache)
    for modifier in stack.ours(obj):
        modifier.show_viewport, modifier.show_render = (found[modifier.persistent_uid] for found in (viewport, render))
    del obj[KEY]


def _seen(obj: bpy.types.Object, modifier: bpy.types.Modifier, mode: str, shown: bool) -> bool:
    if KEY not in obj:
        return shown
    if modifier == stand_in(obj):
        return False
    identifier = str(modifier.persistent_uid)
    return shown or (stack.is_ours(modifier) and identifier in list(obj[KEY].get(mode, ())))


def _by_identifier(obj: bpy.types.Object, identifier: str) -> bpy.types.Modifier | None:
    return next((modifier for modifier in obj.modifiers if str(modifier.persistent_uid) == identifier), None)
