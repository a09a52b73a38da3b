# SPDX-License-Identifier: GPL-3.0-or-later
"""Which properties of an object or data-block are animated, whatever this Blender calls the place of the curves."""

from collections.abc import Iterator

import bpy


def paths(block: bpy.types.ID) -> list[str]:
    """Data paths with keys, drivers or NLA strips, each once, in order of name."""
    data = block.animation_data
    if data is None:
        return []
    strips = [strip for track in data.nla_tracks for strip in track.strips if not (track.mute or strip.mute)]
    found = {curve.data_path for curve in data.drivers}
    for action, slot in [(data.action, data.action_slot), *((strip.action, strip.action_slot) for strip in strips)]:
        found |= {curve.data_path for curve in curves(action, slot)}
    return sorted(found)


def curves(action: bpy.types.Action | None, slot: bpy.types.ActionSlot | None) -> Iterator[bpy.types.FCurve]:
    """The curves that an action has for one of its slots."""
    if action is None or slot is None:
        return
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            if bag is not None:
                yield from bag.fcurves
