# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared Geometry Nodes group "Volume Lattice": what the modifier is to Blender.

It stores what enters in named attributes, so that the evaluated mesh carries it, and takes its output positions from
a result mesh (one for the viewport, one for renders), only where the point counts agree: a stale result shows the
undeformed mesh, never rubbish.
"""

import bpy

from . import group_inputs, sockets
from .incoming_nodes import Incoming
from .node_layer import Socket
from .other_points import OtherPoints

NAME = "Volume Lattice"
VERSION_KEY = "isochor_version"
VERSION = 4
"""Of the inputs and of the nodes that ``_Builder`` lays; a file with an older number gets them anew on loading."""

SHAPING = (sockets.SQUASH, sockets.TAPER, sockets.TWIST, sockets.BEND, sockets.BEND_DIRECTION)
"""The numbers of the panel Animate."""
NUMBERS = (
    *("Strength", "Preserve", "Target", sockets.WHERE_LOST, sockets.REGION_TARGET, sockets.FALLOFF, sockets.HEAVIEST),
    *SHAPING,
)
SWITCHES = (sockets.ISLANDS, sockets.CLOSE_HOLES, sockets.UNFOLDED)


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    """Whether this is a Volume Lattice group, of any version and under any name."""
    return group is not None and VERSION_KEY in group


def all_groups() -> list[bpy.types.NodeTree]:
    """Every Volume Lattice group of the file."""
    return [group for group in bpy.data.node_groups if is_ours(group)]


def ensure() -> bpy.types.NodeTree:
    """The file's own Volume Lattice group, made where there is none."""
    for group in all_groups():
        if group.library is None:
            _renew_old(group)
            return group
    group = bpy.data.node_groups.new(NAME, "GeometryNodeTree")
    group.is_modifier = True
    group_inputs.complete(group)
    _lay_nodes(group)
    return group


def can_transfer() -> bool:
    """Blender 5.2 hands a whole attribute over without copying; before, each position is sampled."""
    return hasattr(bpy.types, "GeometryNodeTransferAttributes")


def rebuild_foreign() -> None:
    """Renews the groups saved by an older version of the add-on, or by a Blender that has nodes unknown to this one.
    Their inputs stay, and with them what every modifier holds; inputs that are new since then come with defaults."""
    for group in all_groups():
        if group.library is None:
            _renew_old(group)


def _renew_old(group: bpy.types.NodeTree) -> None:
    unknown = any(node.bl_idname == "NodeUndefined" for node in group.nodes)
    if unknown or group[VERSION_KEY] < VERSION:
        new = group_inputs.complete(group)
        group.nodes.clear()
        _lay_nodes(group)
        group_inputs.set_defaults(group, new)


def _lay_nodes(group: bpy.types.NodeTree) -> None:
    _Builder(group).build()
    group[VERSION_KEY] = VERSION


class _Builder(Incoming):
    """Lays the nodes of one group."""

    def build(self) -> None:
        geometry = self.inputs.outputs["Geometry"]
        result = self._result()
        vertices = self._vertices(geometry, result)
        others = OtherPoints(self)
        output = self.node("NodeGroupOutput")
        # Blender evaluates only the branch that it takes: a mesh pays for its own alone.
        any_others = self.compare("GREATER_THAN", "INT", others.count(geometry), 0)
        self.link(self.switch("GEOMETRY", any_others, others.moved(geometry, result), vertices), output.inputs[0])
        group_inputs.set_menus(self.group)

    def _vertices(self, geometry: Socket, result: Socket) -> Socket:
        """A mesh alone, with the positions of the result."""
        mesh = self.store_incoming(geometry)
        fits = self.compare("EQUAL", "INT", self.point_count(geometry), self.point_count(result))
        moved = self._take_positions(mesh, result)
        # In the branch that a frame rarely takes, so that no frame pays for it.
        undeformed = self.switch("GEOMETRY", self._every_input_used(), mesh, mesh)
        return self.switch("GEOMETRY", fits, moved, undeformed)

    def _result(self) -> Socket:
        viewport = self.node("GeometryNodeIsViewport").outputs[0]
        return self.switch(
            "GEOMETRY",
            viewport,
            self._object_geometry(sockets.VIEWPORT_RESULT),
            self._object_geometry(sockets.RENDER_RESULT),
        )

    def _object_geometry(self, name: str) -> Socket:
        info = self.node("GeometryNodeObjectInfo", transform_space="ORIGINAL")
        self.link(self.inputs.outputs[name], info.inputs[0])
        return info.outputs["Geometry"]

    def _pins_geometry(self) -> Socket:
        info = self.node("GeometryNodeCollectionInfo", transform_space="ORIGINAL")
        self.link(self.inputs.outputs[sockets.PINS], info.inputs[0])
        return info.outputs[0]

    def _take_positions(self, mesh: Socket, result: Socket) -> Socket:
        if can_transfer():
            transfer = self.node("GeometryNodeTransferAttributes")
            # All but none: the result has positions only.
            transfer.inputs["Exclude Names"].default_value = True
            self.link(mesh, transfer.inputs["Target"])
            self.link(result, transfer.inputs["Source"])
            return transfer.outputs[0]
        sample = self.node("GeometryNodeSampleIndex", data_type="FLOAT_VECTOR")
        self.link(result, sample.inputs["Geometry"])
        self.link(self.node("GeometryNodeInputPosition").outputs[0], sample.inputs["Value"])
        self.link(self.node("GeometryNodeInputIndex").outputs[0], sample.inputs["Index"])
        move = self.node("GeometryNodeSetPosition")
        self.link(mesh, move.inputs["Geometry"])
        self.link(sample.outputs[0], move.inputs["Position"])
        return move.outputs[0]

    def _every_input_used(self) -> Socket:
        """True always, through every input that only the add-on reads: Blender greys out what reaches no output."""
        total: Socket | float = 0.0
        for name in (*NUMBERS, *SWITCHES):
            total = self.floats("ADD", total, self.inputs.outputs[name])
        for name in sockets.MENUS:
            total = self.floats("ADD", total, self._menu_number(name))
        length = self.node("ShaderNodeVectorMath", operation="LENGTH")
        self.link(self.inputs.outputs["Axes"], length.inputs[0])
        total = self.floats("ADD", total, length.outputs["Value"])
        for name in (sockets.STIFFNESS, sockets.WEIGHTS):
            total = self.floats("ADD", total, self.length(name))
        for geometry in (*map(self._object_geometry, (sockets.LATTICE, sockets.FRAME)), self._pins_geometry()):
            total = self.floats("ADD", total, self.point_count(geometry))
        return self.compare("EQUAL", "FLOAT", self.floats("MULTIPLY", total, 0.0), 0.0)

    def _menu_number(self, name: str) -> Socket:
        switch = self.node("GeometryNodeMenuSwitch", data_type="FLOAT")
        for item, text in zip(switch.enum_items, sockets.MENUS[name], strict=False):
            item.name = text
        for text in sockets.MENUS[name][len(switch.enum_items) :]:
            switch.enum_items.new(text)
        self.link(self.inputs.outputs[name], switch.inputs[0])
        return switch.outputs[0]
