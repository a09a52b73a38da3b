# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in for our modifiers after a bake: which modifier or shape keys, and how ours were switched before.

Kept as a custom property of the object, so that it goes with the file: the modifiers by their identifiers, which
neither renaming nor moving changes. Of a library override Blender saves no custom properties, and identifiers only of
modifiers that the library has: there the result objects of ours keep it, and the modifiers go by their names.
"""

from collections.abc import Sequence
from typing import Any

import bpy

from . import animation_paths, frame_keys, influence_group, lattices, results, stack

KEY = "isochor_bake"
"""Custom property of an object: {"cache": identifier, or empty where shape keys play; "keys": their names; "basis":
whether the bake made the first of them; "viewport" and "render": identifiers of ours that were on}."""
MADE_BY_BAKE = "isochor_baked"
"""Custom property of a lattice object that a bake made, so that it goes with the bake."""


def is_playing(obj: bpy.types.Object) -> bool:
    """Whether a bake plays in the place of ours, which perhaps are gone."""
    return bool(_note(obj))


def stand_in(obj: bpy.types.Object) -> bpy.types.Modifier | None:
    """The modifier that plays the bake, or None where there is none (any more)."""
    wanted = [_note(obj).get("cache", "")]
    return next((modifier for modifier in obj.modifiers if _is_among(modifier, wanted)), None)


def keys(obj: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """The shape keys that play the bake, none where something else does."""
    names = list(_note(obj).get("keys", ()))
    held = getattr(obj.data, "shape_keys", None)
    blocks = {} if held is None else held.key_blocks
    return [blocks[name] for name in names if name in blocks]


def seen_by_renders(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> bool:
    """Whether renders see this modifier where nothing is baked: what a bake switched off counts as on, what it made
    as off."""
    return _seen(obj, modifier, "render", modifier.show_render)


def seen_in_viewport(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> bool:
    """The same for the viewport."""
    return _seen(obj, modifier, "viewport", modifier.show_viewport)


def switch_over(
    obj: bpy.types.Object,
    cache: bpy.types.Modifier | None,
    modes: tuple[str, ...],
    keys: tuple[str, ...] = (),
    basis: bool = False,
) -> None:
    """Has ``cache``, or without it the shape keys of these names, play instead of ours in these modes ("viewport",
    "render"), and notes how ours were before. ``basis``: whether the keys' basis goes with them."""
    note: dict[str, Any] = {"cache": "" if cache is None else _identifier(cache)}
    note["keys"], note["basis"] = list(keys), basis
    ours = stack.ours(obj)
    for mode, was_on in (("viewport", seen_in_viewport), ("render", seen_by_renders)):
        note[mode] = [_identifier(modifier) for modifier in ours if was_on(obj, modifier)]
    _keep(obj, note)
    for mode in ("viewport", "render"):
        for modifier in ours:
            on = mode not in modes and _is_among(modifier, note[mode])
            setattr(modifier, f"show_{mode}", on)
        if cache is not None:
            setattr(cache, f"show_{mode}", mode in modes)


def switch_back(obj: bpy.types.Object) -> None:
    """Takes what plays the bake away and switches ours as they were."""
    viewport = {modifier.persistent_uid: seen_in_viewport(obj, modifier) for modifier in stack.ours(obj)}
    render = {modifier.persistent_uid: seen_by_renders(obj, modifier) for modifier in stack.ours(obj)}
    drop(obj)
    for modifier in stack.ours(obj):
        modifier.show_viewport, modifier.show_render = (found[modifier.persistent_uid] for found in (viewport, render))
    for holder in _holders(obj):
        if KEY in holder:
            del holder[KEY]


def drop(obj: bpy.types.Object) -> None:
    """Takes what plays the bake away, with its animation and, where nothing else uses it, the lattice made for it; how
    ours were switched stays noted."""
    note = _note(obj)
    if not note:
        return
    cache = stand_in(obj)
    if cache is not None:
        lattice, group = (cache.object, cache.vertex_group) if cache.type == "LATTICE" else (None, "")
        path = animation_paths.of_modifier(cache)
        obj.modifiers.remove(cache)
        animation_paths.remove(obj, [path])
        influence_group.remove(obj, group)
        if lattice is not None and MADE_BY_BAKE in lattice and not lattices.is_used(lattice):
            _drop_lattice(lattice)
    frame_keys.remove(obj, keys(obj), bool(note.get("basis", False)))
    _keep(obj, {**note, "cache": "", "keys": [], "basis": False})


def _drop_lattice(lattice: bpy.types.Object) -> None:
    data = lattice.data
    if data.users == 1:
        frame_keys.remove(lattice, list(data.shape_keys.key_blocks)[1:], basis_too=True)
    bpy.data.objects.remove(lattice)
    if data.users == 0:
        bpy.data.lattices.remove(data)


def _seen(obj: bpy.types.Object, modifier: bpy.types.Modifier, mode: str, shown: bool) -> bool:
    note = _note(obj)
    if not note:
        return shown
    if _is_among(modifier, [note["cache"]]):
        return False
    return shown or (stack.is_ours(modifier) and _is_among(modifier, note.get(mode, ())))


def _note(obj: bpy.types.Object) -> dict[str, Any]:
    """What is kept of the bake; empty where none plays."""
    return next((holder[KEY].to_dict() for holder in _holders(obj) if KEY in holder), {})


def _keep(obj: bpy.types.Object, note: dict[str, Any]) -> None:
    own, *kept = _holders(obj)
    for holder in kept if kept and obj.override_library is not None else (own,):
        holder[KEY] = note


def _holders(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The object first, then the result objects of ours."""
    shown = [results.of(modifier, "VIEWPORT") for modifier in stack.ours(obj)]
    return [obj, *(result for result in shown if result is not None)]


def _identifier(modifier: bpy.types.Modifier) -> str:
    return modifier.name if modifier.id_data.override_library is not None else str(modifier.persistent_uid)


def _is_among(modifier: bpy.types.Modifier, identifiers: Sequence[str]) -> bool:
    return str(modifier.persistent_uid) in identifiers or modifier.name in identifiers
