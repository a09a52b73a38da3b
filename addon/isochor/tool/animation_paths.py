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


def rename(owner: bpy.types.ID, paths: dict[str, str]) -> None:
    """Has what animates the owner at one of these paths go to another."""
    animation = owner.animation_data
    for curve in [] if animation is None else [*animation.drivers, *_own_curves(animation)]:
        curve.data_path = paths.get(curve.data_path, curve.data_path)


def readers(owner: bpy.types.ID, paths: list[str]) -> bool:
    """Whether drivers anywhere read the owner at one of these paths."""
    return any(target.id == owner and target.data_path in paths for target in _every_target())


def targets_of(read: bpy.types.ID) -> list[bpy.types.DriverTarget]:
    """Of the drivers of other data that read something of ``read``."""
    return [target for target in _every_target(but=read) if target.id == read]


def curves_at(owner: bpy.types.ID, path: str) -> list[bpy.types.FCurve]:
    """Keys at this path of the owner, in every action that it plays."""
    animation = owner.animation_data
    played = [] if animation is None else _played(animation)
    return [curve for one in played for curve in _curves_of(*one) if curve.data_path == path]


def not_alone(owner: bpy.types.ID, paths: list[str]) -> str:
    """Name of an action with curves at one of these paths that other data plays too, or another file owns; empty where
    there is none."""
    animation = owner.animation_data
    if animation is None:
        return ""
    own = [action for action, _slot in _actions(animation)]
    for action, slot in _played(animation):
        if action not in own and any(curve.data_path in paths for curve in _curves_of(action, slot)):
            return str(action.name)
    return ""


def _own_curves(animation: bpy.types.AnimData) -> list[bpy.types.FCurve]:
    return [curve for action, slot in _actions(animation) for curve in _curves_of(action, slot)]


def _curves_of(action: bpy.types.Action, slot: bpy.types.ActionSlot) -> list[bpy.types.FCurve]:
    bags = [strip.channelbag(slot) for strip in _strips(action)]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def _every_target(but: bpy.types.ID | None = None) -> Iterator[bpy.types.DriverTarget]:
    """What drivers read: those of all data in the file, node trees inside other data too, ``but`` one."""
    for found in bpy.data.user_map():
        for block in (found, getattr(found, "node_tree", None)):
            animation = None if block is None or block == but else getattr(block, "animation_data", None)
            for curve in [] if animation is None else animation.drivers:
                yield from (target for variable in curve.driver.variables for target in variable.targets)


def _played(animation: bpy.types.AnimData) -> list[tuple[bpy.types.Action, bpy.types.ActionSlot]]:
    """Every action and slot that this data plays, the NLA's too."""
    strips = [strip for track in animation.nla_tracks for strip in track.strips]
    played = [(holder.action, holder.action_slot) for holder in (animation, *strips)]
    return [(action, slot) for action, slot in dict.fromkeys(played) if action is not None and slot is not None]


def _actions(animation: bpy.types.AnimData) -> list[tuple[bpy.types.Action, bpy.types.ActionSlot]]:
    """Every action and slot, the NLA's too, that this data alone plays and this file owns."""
    return [
        (action, slot)
        for action, slot in _played(animation)
        if action.is_editable and set(slot.users()) <= {animation.id_data}
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
