# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs that the node group shows in the modifier: names, kinds, panels, defaults, tooltips."""

from typing import Any

import bpy

from ..core import settings
from . import sockets

MENU_DEFAULTS = {"Axis": "Z"}
"""Of the menus whose default is not their first item."""
PANELS = ("Volume", "Pins", "Animate", "Interpolation")
"""From top to bottom."""
BEHIND = ((sockets.FRAME, "Space"), ("Cost", "Method"))
"""Inputs that came later and stand right behind one that was there: (input, the one before it)."""


def complete(group: bpy.types.NodeTree) -> list[str]:
    """Adds the inputs that the group lacks, all of them to a new one; returns their names. Menus need ``set_menus``
    once nodes use them."""
    before = {item.name for item in _inputs(group)}
    if not before:
        group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    # In the order in which versions brought them: so a new group has the identifiers, and with them the paths of keys
    # and drivers, of one that came with an older file.
    _add_first_inputs(group)
    _add_volume_inputs(group, _panel(group, "Volume"))
    _add_interpolation_inputs(group, _panel(group, "Interpolation", closed=True))
    _add_kept_inputs(group)
    _add_animate_inputs(group, _panel(group, "Animate", closed=True))
    _add_local_inputs(group, _panel(group, "Volume"))
    _add_pin_inputs(group, _panel(group, "Pins", closed=True))
    _add_blending_inputs(group, _panel(group, "Interpolation", closed=True))
    _order_panels(group)
    _order_inputs(group)
    sockets.forget(group)
    return [item.name for item in _inputs(group) if item.name not in before]


def set_menus(group: bpy.types.NodeTree) -> None:
    """Gives the menus their defaults, which Blender takes only where a Menu Switch says what the items are."""
    for item in _inputs(group):
        if item.name in sockets.MENUS:
            item.default_value = MENU_DEFAULTS.get(item.name, sockets.MENUS[item.name][0])


def set_defaults(group: bpy.types.NodeTree, names: list[str]) -> None:
    """Writes the defaults of inputs that are new in the group into every modifier: Blender leaves zeros in them."""
    defaults = {item.name: item.default_value for item in _inputs(group) if item.name in names}
    for obj in bpy.data.objects:
        for modifier in obj.modifiers:
            if obj.is_editable and modifier.type == "NODES" and modifier.node_group == group:
                for name, value in defaults.items():
                    sockets.write(modifier, name, value)


def _add_first_inputs(group: bpy.types.NodeTree) -> None:
    _input(group, sockets.LATTICE, "Object", "The Lattice object whose points shape the mesh")
    _factor(group, "Strength", "How much of the deformation each vertex takes")
    _input(group, "Vertex Group", "String", "Vertex group that scales the deformation vertex by vertex")
    _input(group, "Invert", "Bool", "Use one minus the vertex group's weights")


def _add_kept_inputs(group: bpy.types.NodeTree) -> None:
    for name, kind in (
        (sockets.VIEWPORT_RESULT, "Object"),
        (sockets.RENDER_RESULT, "Object"),
        (sockets.SLOT, "String"),
    ):
        _input(group, name, kind, "Kept by the add-on", hide_in_modifier=True)


def _add_volume_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    _factor(group, "Preserve", "How much of the lost or gained volume is restored", panel)
    _menu(
        group, "Reference", "The volume to keep: when the modifier was added or its rest set, or in this frame", panel
    )
    _input(group, "Target", "Float", "Factor on the volume to keep", panel, default_value=1.0, min_value=0.0)
    axes = "Shares of X, Y and Z in the correction; 0 leaves an axis alone"
    _input(group, "Axes", "Vector", axes, panel, default_value=(1.0, 1.0, 1.0), min_value=0.0)
    space = "What X, Y and Z mean in Axes: the world's, the object's, the lattice's, or those of the object under Frame"
    _menu(group, "Space", space, panel)
    method = (
        "Balanced keeps round shapes round; Sweep is the published method; Gradient takes one step in all directions at"
        " once; Nearest moves the lattice least"
    )
    _menu(group, "Method", method, panel)


def _add_local_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    frame = "With Space at Custom: the object whose own X, Y and Z are meant in Axes, such as an empty that is turned"
    _input(group, sockets.FRAME, "Object", frame, panel)
    _menu(group, "Cost", "What Nearest keeps small: how far points move, or the surface, or how much it bends", panel)
    stiffness = (
        "Vertex group of the lattice: how much each point resists the correction, from 0 (free) to 1 (stays put)"
    )
    _input(group, sockets.STIFFNESS, "String", stiffness, panel)
    lost = "How much of the correction goes where the volume went: 0 spreads it evenly, 1 follows the loss"
    _factor(group, sockets.WHERE_LOST, lost, panel, default_value=0.0)
    _input(group, sockets.ISLANDS, "Bool", "Each closed piece of the mesh keeps a volume of its own", panel)
    _input(group, sockets.REGION, "String", "Vertex group of a part that keeps a volume of its own", panel)
    region = "Factor on the region's volume to keep, in place of Target"
    _input(group, sockets.REGION_TARGET, "Float", region, panel, default_value=1.0, min_value=0.0)
    holes = "Measure an open mesh as if its holes were closed; it stays open"
    _input(group, sockets.CLOSE_HOLES, "Bool", holes, panel)
    unfolded = "Stop the correction where it would turn space inside out; the sidebar says how much is then missing"
    _input(group, sockets.UNFOLDED, "Bool", unfolded, panel)


def _add_pin_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    pins = "Empties that hold points of the surface: where an empty goes, its point of the surface follows"
    _input(group, sockets.PINS, "Collection", pins, panel)
    falloff = "Distance from the pins at which the correction fades; 0 spreads it over the whole lattice"
    _input(group, sockets.FALLOFF, "Float", falloff, panel, subtype="DISTANCE", min_value=0.0)


def _add_animate_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    _menu(group, "Axis", "The lattice's own axis along which squash, taper, twist and bend act", panel)
    squash = "Length along the axis as a factor: below 1 squashes, above 1 stretches. The volume's correction bulges it"
    _input(group, sockets.SQUASH, "Float", squash, panel, default_value=1.0, min_value=0.0)
    taper = "How much wider the top is than the bottom, as a fraction of the width at the pivot; 0 leaves it straight"
    _input(group, sockets.TAPER, "Float", taper, panel)
    _angle(group, sockets.TWIST, "Turn of the top against the bottom, about the axis", panel)
    _angle(group, sockets.BEND, "Angle of the arc into which the axis is bent, at constant length", panel)
    direction = "Which way it bends: 0° is the axis that follows (for Z: X), 90° the one after that (for Z: Y)"
    _angle(group, sockets.BEND_DIRECTION, direction, panel)
    _menu(group, "Pivot", "What stays in place: the bottom of the lattice, its centre or its top", panel)


def _add_interpolation_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    basis = (
        "Bernstein: every point reaches everywhere; B-Spline: each reaches its neighbourhood; Blender: as Blender's own"
        " Lattice modifier"
    )
    _menu(group, "Basis", basis, panel)
    _menu(group, "Outside", "Vertices outside the lattice: keep them, or extend the deformation to them", panel)


def _add_blending_inputs(group: bpy.types.NodeTree, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    weights = "Vertex group of the lattice: how strongly each point pulls, from 1 outside of the group to Heaviest"
    _input(group, sockets.WEIGHTS, "String", weights, panel)
    heaviest = "How strongly a point with weight 1 in the group pulls, as a factor on one outside of it"
    least = {"default_value": settings.HEAVIEST, "min_value": 0.001}
    _input(group, sockets.HEAVIEST, "Float", heaviest, panel, **least)
    joint = (
        "With Outside at Keep: how smoothly the shape joins vertices beyond the lattice. C0: it does not tear; C1: no"
        " crease; C2: no jump in curvature"
    )
    _menu(group, sockets.JOINT, joint, panel)


def _input(
    group: bpy.types.NodeTree,
    name: str,
    kind: str,
    description: str,
    panel: bpy.types.NodeTreeInterfacePanel | None = None,
    **properties: Any,
) -> None:
    """Adds the input unless the group has one of that name."""
    if any(item.name == name for item in _inputs(group)):
        return
    socket = group.interface.new_socket(
        name, description=description, in_out="INPUT", socket_type=f"NodeSocket{kind}", parent=panel
    )
    if kind in ("Float", "Bool", "Vector"):
        # One value for the whole mesh: no button to take it from an attribute.
        socket.force_non_field = True
    for key, value in properties.items():
        setattr(socket, key, value)


def _factor(
    group: bpy.types.NodeTree,
    name: str,
    description: str,
    panel: bpy.types.NodeTreeInterfacePanel | None = None,
    default_value: float = 1.0,
) -> None:
    limits = {"default_value": default_value, "min_value": 0.0, "max_value": 1.0}
    _input(group, name, "Float", description, panel, subtype="FACTOR", **limits)


def _angle(group: bpy.types.NodeTree, name: str, description: str, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    _input(group, name, "Float", description, panel, subtype="ANGLE")


def _menu(group: bpy.types.NodeTree, name: str, description: str, panel: bpy.types.NodeTreeInterfacePanel) -> None:
    _input(group, name, "Menu", description, panel)


def _inputs(group: bpy.types.NodeTree) -> list[bpy.types.NodeTreeInterfaceSocket]:
    return [item for item in group.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "INPUT"]


def _panels(group: bpy.types.NodeTree) -> dict[str, bpy.types.NodeTreeInterfacePanel]:
    return {item.name: item for item in group.interface.items_tree if item.item_type == "PANEL"}


def _panel(group: bpy.types.NodeTree, name: str, closed: bool = False) -> bpy.types.NodeTreeInterfacePanel:
    return _panels(group).get(name) or group.interface.new_panel(name, default_closed=closed)


def _order_panels(group: bpy.types.NodeTree) -> None:
    """Puts ours in their order, each behind all that stood before it."""
    found = _panels(group)
    if [name for name in found if name in PANELS] != list(PANELS):
        for name in PANELS:
            group.interface.move(found[name], len(group.interface.items_tree))


def _order_inputs(group: bpy.types.NodeTree) -> None:
    """Puts each input of ``BEHIND`` in its place among those of its panel."""
    for name, before in BEHIND:
        found = {item.name: item for item in _inputs(group)}
        siblings = [item.name for item in _inputs(group) if item.parent == found[name].parent]
        if siblings.index(name) != siblings.index(before) + 1:
            group.interface.move_to_parent(found[name], found[name].parent, siblings.index(before) + 1)
