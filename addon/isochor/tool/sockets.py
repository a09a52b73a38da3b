# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs of a Volume Lattice modifier, whose home differs between Blender 4.5 and 5.2.

4.5 keeps them as custom properties of the modifier, menus as integers; 5.2 under ``modifier.properties.inputs``,
menus as names.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import bpy

from ..core import settings

MENUS = {
    "Reference": settings.REFERENCES,
    "Space": settings.SPACES,
    "Method": settings.METHODS,
    "Basis": settings.BASES,
    "Outside": settings.OUTSIDES,
    "Axis": settings.AXES,
    "Pivot": settings.PIVOTS,
    "Cost": settings.COSTS,
    "Joint": settings.JOINTS,
}
SQUASH, TAPER, TWIST, BEND, BEND_DIRECTION = "Squash", "Taper", "Twist", "Bend", "Bend Direction"
VIEWPORT_RESULT, RENDER_RESULT, SLOT = "Viewport Result", "Render Result", "Slot"
LATTICE, FRAME, PINS = "Lattice", "Frame", "Pins"
STIFFNESS, REGION, REGION_TARGET = "Stiffness", "Region", "Region Target"
ISLANDS, CLOSE_HOLES, WHERE_LOST, UNFOLDED, FALLOFF = "Islands", "Close Holes", "Where Lost", "Unfolded", "Falloff"
WEIGHTS, HEAVIEST, JOINT = "Weights", "Heaviest", "Joint"
OBJECTS = (LATTICE, FRAME, PINS, VIEWPORT_RESULT, RENDER_RESULT)
"""Those that hold an object or a collection."""


_identifiers: dict[int, dict[str, str]] = {}
"""What ``identifiers`` has found, by the session identifier of the original group: evaluated ones all have 0."""


def identifiers(group: bpy.types.NodeTree) -> dict[str, str]:
    """Name to identifier of every input of the node group."""
    uid = group.original.session_uid
    if uid not in _identifiers:
        _identifiers[uid] = {
            item.name: item.identifier
            for item in group.interface.items_tree
            if item.item_type == "SOCKET" and item.in_out == "INPUT"
        }
    return _identifiers[uid]


def forget(group: bpy.types.NodeTree) -> None:
    """The group's inputs have changed: they are looked up again."""
    _identifiers.pop(group.original.session_uid, None)


def data_path(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of an input from its modifier, for keys and drivers."""
    identifier = identifiers(modifier.node_group)[name]
    return f"properties.inputs.{identifier}.value" if _as_properties(modifier) else f'["{identifier}"]'


def property_of(modifier: bpy.types.NodesModifier, name: str) -> tuple[Any, str]:
    """What holds an input and the name of the property in it, for a layout to show."""
    identifier = identifiers(modifier.node_group)[name]
    if _as_properties(modifier):
        return getattr(modifier.properties.inputs, identifier), "value"
    return modifier, f'["{identifier}"]'


def read(modifier: bpy.types.NodesModifier, name: str) -> Any:
    """Value of an input; of an evaluated modifier, with drivers and keys applied. Menus give the item's name."""
    return reader(modifier)(name)


def reader(modifier: bpy.types.NodesModifier) -> Callable[[str], Any]:
    """What reads several inputs of one modifier, each by its name, quicker than ``read`` one by one."""
    known = identifiers(modifier.node_group)
    if _as_properties(modifier):
        inputs = modifier.properties.inputs
        return lambda name: getattr(inputs, known[name]).value

    def value(name: str) -> Any:
        found = modifier[known[name]]
        return MENUS[name][found] if name in MENUS else found

    return value


def write(modifier: bpy.types.NodesModifier, name: str, value: Any) -> None:
    """Sets an input and tells Blender that the modifier has changed. Menus take the item's name."""
    identifier = identifiers(modifier.node_group)[name]
    if _as_properties(modifier):
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        modifier[identifier] = MENUS[name].index(value) if name in MENUS else value
    modifier.id_data.update_tag()
    if name in OBJECTS:
        # Of all that a script can set, only the group makes Blender look for what the modifier depends on.
        modifier.node_group = modifier.node_group


def read_settings(modifier: bpy.types.NodesModifier) -> settings.Settings:
    """Everything but the objects, from an evaluated modifier. A group linked from a file older than the panel Animate
    has no inputs of it, which then shape nothing; so for what came later."""
    value = reader(modifier)
    known = identifiers(modifier.node_group)
    x, y, z = value("Axes")
    found = settings.Settings(
        strength=value("Strength"),
        vertex_group=value("Vertex Group"),
        invert=bool(value("Invert")),
        preserve=value("Preserve"),
        reference=value("Reference"),
        target=value("Target"),
        axes=(x, y, z),
        space=value("Space"),
        method=value("Method"),
        basis=value("Basis"),
        outside=value("Outside"),
        shaping=_read_shaping(value) if SQUASH in known else settings.Shaping(),
    )
    later = _read_later(value, found.method) if ISLANDS in known else {}
    later |= _read_blending(value) if WEIGHTS in known else {}
    return replace(found, **later) if later else found


def _read_shaping(value: Callable[[str], Any]) -> settings.Shaping:
    """The inputs of the panel Animate; by their defaults where they cannot matter, which saves reading them."""
    squash, taper, twist, bend = value(SQUASH), value(TAPER), value(TWIST), value(BEND)
    if (squash, taper, twist, bend) == settings.NEUTRAL:
        return settings.Shaping()
    return settings.Shaping(value("Axis"), squash, taper, twist, bend, value(BEND_DIRECTION), value("Pivot"))


def _read_later(value: Callable[[str], Any], method: str) -> dict[str, Any]:
    """What differs from its default among the inputs that came with version 3, by the name of its field; those are
    read first on which others depend."""
    parts = bool(value(ISLANDS)), bool(value(CLOSE_HOLES)), value(REGION)
    found: dict[str, Any] = {
        "stiffness": value(STIFFNESS),
        "where_lost": max(0.0, min(1.0, value(WHERE_LOST))),
        "unfolded": bool(value(UNFOLDED)),
        "falloff": max(0.0, value(FALLOFF)),
    }
    if any(parts):
        found["parts"] = settings.Parts(*parts, value(REGION_TARGET) if parts[2] else 1.0)
    if method == "Nearest":
        found["cost"] = value("Cost")
    return {name: kept for name, kept in found.items() if kept}


def _read_blending(value: Callable[[str], Any]) -> dict[str, Any]:
    """The same of those that came with version 4."""
    found: dict[str, Any] = {}
    if value(JOINT) != settings.JOINTS[0]:
        found["joint"] = value(JOINT)
    if value(WEIGHTS):
        found["weights"], found["heaviest"] = value(WEIGHTS), value(HEAVIEST)
    return found


def _as_properties(modifier: bpy.types.NodesModifier) -> bool:
    return hasattr(modifier, "properties")
