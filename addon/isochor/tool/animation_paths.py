# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and drivers under one data path, which Blender leaves behind when what they animate goes."""

from collections.abc import Iterator

import bpy


def of_modifier(modifier: bpy.types.Modifier) -> str:
    """Path of a modifier from its object."""
    return f'modifiers["{bpy.utils.escape_identifier(modifier.name)}"]'


def of_key(block: bpy.types.ShapeKey) -> str:
    """Path of a shape key from its data-block."""
    return f'key_blocks["{bpy.utils.escape_identifier(block.name)}"]'


def remove(owner: bpy.types.ID, paths: list[str]) -> None:
    """Takes drivers and curves of the owner under these paths away, and an action that then holds nothing. What other
    data plays too, or another file owns, is left alone."""
    animation = owner.animation_data
    if animation is None:
        return
    starts = tuple(paths)
    for driver in [driver for driver in animation.drivers if driver.data_path.startswith(starts)]:
        animation.drivers.remove(driver)
    for action, slot in _actions(animation):
        if _remove_curves(action, slot, starts) and not list(_all_curves(action)):
            _drop(animation, action)


def _actions(animation: bpy.types.AnimData) -> list[tuple[bpy.types.Action, bpy.types.ActionSlot]]:
    """Every action and slot, the NLA's too, that this data alone plays and this file owns."""
    strips = [strip for track in animation.nla_tracks for strip in track.strips]
    played = [(holder.action, holder.action_slot) for holder in (animation, *strips)]
    return [
        (action, slot)
        for action, slot in dict.fromkeys(played)
        if action is not None and slot is not None and action.is_editable and set(slot.users()) <= {animation.id_data}
    ]


def _remove_curves(action: bpy.types.Action, slot: bpy.types.ActionSlot, starts: tuple[str, ...]) -> bool:
    """Whether there were any whose data path starts with one of these."""
    found = False
    for strip in _strips(action):
        bag = strip.channelbag(slot)
        for curve in [] if bag is None else [curve for curve in bag.fcurves if curve.data_path.startswith(starts)]:
            bag.fcurves.remove(curve)
            found = True
    return found


def _drop(animation: bpy.types.AnimData, action: bpy.types.Action) -> None:
    """Takes an empty action away, unless an NLA strip plays it or somebody keeps it."""
    if animation.action == action:
        animation.action = None
    if action.users == 0:
        bpy.data.actions.remove(action)


def _strips(action: bpy.types.Action) -> Iterator[bpy.types.ActionKeyframeStrip]:
    return (strip for layer in action.layers for strip in layer.strips)


def _all_curves(action: bpy.types.Action) -> Iterator[bpy.types.FCurve]:
    return (curve for strip in _strips(action) for bag in strip.channelbags for curve in bag.fcurves)
