# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds, finds and sets the extension's modifier "Volume Lattice" as a user's script would (bpy)."""

from typing import Any

import bpy
from blender_session import DemoError

MODIFIER_NAME = "Volume Lattice"


def add_volume_lattice(
    ball: bpy.types.Object,
    points: tuple[int, int, int],
    basis: str = "BSPLINE",
    margin: float = 0.05,
    fit: str = "LOCAL",
) -> bpy.types.Object:
    """Gives `ball` the modifier through the extension's operator, corrected in x and y; returns its lattice object."""
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = ball
    ball.select_set(True)
    outcome = bpy.ops.isochor.add(resolution=points, basis=basis, fit=fit, margin=margin)
    if outcome != {"FINISHED"}:
        raise DemoError(f"isochor.add on {ball.name!r} answered {outcome}, expected FINISHED.")
    modifier = find_volume_lattice(ball)
    set_input(modifier, "Axes", (1.0, 1.0, 0.0))
    set_input(modifier, "Preserve", 1.0)
    return get_input(modifier, "Lattice")


def find_volume_lattice(ball: bpy.types.Object) -> bpy.types.NodesModifier:
    """The extension's modifier on `ball`."""
    for modifier in ball.modifiers:
        group = modifier.node_group if modifier.type == "NODES" else None
        if group is not None and group.name.startswith(MODIFIER_NAME):
            return modifier
    present = ", ".join(modifier.name for modifier in ball.modifiers) or "none"
    raise DemoError(f"{ball.name!r} has no modifier {MODIFIER_NAME!r} (it has: {present}); make the fixture again.")


def _identifier(modifier: bpy.types.NodesModifier, name: str) -> str:
    for item in modifier.node_group.interface.items_tree:
        if item.item_type == "SOCKET" and item.in_out == "INPUT" and item.name == name:
            return str(item.identifier)
    raise DemoError(f"modifier {modifier.name!r} has no input {name!r}; the fixture and the extension do not fit.")


def input_path(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of the input called `name` from the modifier, for keys."""
    identifier = _identifier(modifier, name)
    return f"properties.inputs.{identifier}.value" if hasattr(modifier, "properties") else f'["{identifier}"]'


def get_input(modifier: bpy.types.NodesModifier, name: str) -> Any:
    """Value of the modifier's input called `name`."""
    identifier = _identifier(modifier, name)
    if hasattr(modifier, "properties"):  # Blender 5.2 and later
        return getattr(modifier.properties.inputs, identifier).value
    return modifier[identifier]


def set_input(modifier: bpy.types.NodesModifier, name: str, value: Any) -> None:
    """Sets the modifier's input called `name`, and tells Blender that it changed."""
    identifier = _identifier(modifier, name)
    if hasattr(modifier, "properties"):  # Blender 5.2 and later
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        is_item = isinstance(value, str) and bool(menu_items(modifier, name))
        modifier[identifier] = _menu_number(modifier, name, value) if is_item else value
    modifier.id_data.update_tag()


def menu_items(modifier: bpy.types.NodesModifier, name: str) -> list[str]:
    """Names of a menu's items, in the order of the group's Menu Switch; none of an input that is no menu."""
    for node in modifier.node_group.nodes:
        if node.bl_idname == "GeometryNodeMenuSwitch" and node.inputs[0].links[0].from_socket.name == name:
            return [item.name for item in node.enum_items]
    return []


def _menu_number(modifier: bpy.types.NodesModifier, name: str, item: str) -> int:
    """What Blender 4.5 keeps of a menu: the item's number."""
    items = menu_items(modifier, name)
    if item not in items:
        raise DemoError(f"modifier {modifier.name!r} has no {item!r} in a menu {name!r}: it has {items}.")
    return items.index(item)
