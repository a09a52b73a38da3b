# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared Geometry Nodes group "Volume Lattice": what the modifier is to Blender.

It stores what enters in named attributes, so that the evaluated mesh carries it, and takes its output positions from
a result mesh (one for the viewport, one for renders), only where the point counts agree: a stale result shows the
undeformed mesh, never rubbish.
"""

import bpy

from . import group_inputs, sockets

NAME = "Volume Lattice"
VERSION_KEY = "isochor_version"
VERSION = 4
"""Of the inputs and of the nodes that ``_Builder`` lays; a file with an older number gets them anew on loading."""

INCOMING = ".isochor_incoming_"
"""Point, vector: positions that entered. A leading dot hides an attribute in Blender's lists; the slot follows."""
ORDER = ".isochor_order_"
"""Point, integer: number of points that entered less the point's index, which proves that none is lost or moved."""
MASK = ".isochor_mask_"
"""Point, float: weight of the vertex group, inverted where asked; stored only where a group is named."""

REGION = ".isochor_region_"
"""Point, float: weight of the vertex group whose part keeps a volume of its own; stored only where one is named."""

SHAPING = (sockets.SQUASH, sockets.TAPER, sockets.TWIST, sockets.BEND, sockets.BEND_DIRECTION)
"""The numbers of the panel Animate."""
NUMBERS = (
    *("Strength", "Preserve", "Target", sockets.WHERE_LOST, sockets.REGION_TARGET, sockets.FALLOFF, sockets.HEAVIEST),
    *SHAPING,
)
SWITCHES = (sockets.ISLANDS, sockets.CLOSE_HOLES, sockets.UNFOLDED)

Socket = bpy.types.NodeSocket


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


class _Builder:
    """Lays the nodes of one group."""

    def __init__(self, group: bpy.types.NodeTree) -> None:
        self._group = group
        self._inputs = self._node("NodeGroupInput")

    def build(self) -> None:
        mesh = self._store_incoming(self._inputs.outputs["Geometry"])
        result = self._result()
        fits = self._counts_agree(self._inputs.outputs["Geometry"], result)
        moved = self._take_positions(mesh, result)
        output = self._node("NodeGroupOutput")
        # In the branch that a frame rarely takes, so that no frame pays for it.
        undeformed = self._switch("GEOMETRY", self._every_input_used(), mesh, mesh)
        self._link(self._switch("GEOMETRY", fits, moved, undeformed), output.inputs[0])
        group_inputs.set_menus(self._group)

    def _store_incoming(self, mesh: Socket) -> Socket:
        position = self._node("GeometryNodeInputPosition").outputs[0]
        mesh = self._store(mesh, INCOMING, "FLOAT_VECTOR", position)
        index = self._node("GeometryNodeInputIndex").outputs[0]
        mesh = self._store(mesh, ORDER, "INT", self._integers("SUBTRACT", self._point_count(mesh), index))
        mesh = self._store_where_named("Vertex Group", mesh, MASK, self._mask())
        return self._store_where_named(sockets.REGION, mesh, REGION, self._weight(sockets.REGION))

    def _store_where_named(self, name: str, mesh: Socket, prefix: str, value: Socket) -> Socket:
        """Stores a number a point where the text input of this name is not empty."""
        some = self._compare("GREATER_THAN", "INT", self._length(name), 0)
        return self._switch("GEOMETRY", some, self._store(mesh, prefix, "FLOAT", value), mesh)

    def _mask(self) -> Socket:
        weight = self._weight("Vertex Group")
        return self._switch("FLOAT", self._inputs.outputs["Invert"], self._floats("SUBTRACT", 1.0, weight), weight)

    def _weight(self, name: str) -> Socket:
        """Weight of each point in the vertex group that the input of this name names."""
        weight = self._node("GeometryNodeInputNamedAttribute", data_type="FLOAT")
        self._link(self._inputs.outputs[name], weight.inputs["Name"])
        return weight.outputs["Attribute"]

    def _length(self, name: str) -> Socket:
        """Letters of the text input of this name."""
        length = self._node("FunctionNodeStringLength")
        self._link(self._inputs.outputs[name], length.inputs[0])
        return length.outputs[0]

    def _result(self) -> Socket:
        viewport = self._node("GeometryNodeIsViewport").outputs[0]
        return self._switch(
            "GEOMETRY",
            viewport,
            self._object_geometry(sockets.VIEWPORT_RESULT),
            self._object_geometry(sockets.RENDER_RESULT),
        )

    def _object_geometry(self, name: str) -> Socket:
        info = self._node("GeometryNodeObjectInfo", transform_space="ORIGINAL")
        self._link(self._inputs.outputs[name], info.inputs[0])
        return info.outputs["Geometry"]

    def _pins_geometry(self) -> Socket:
        info = self._node("GeometryNodeCollectionInfo", transform_space="ORIGINAL")
        self._link(self._inputs.outputs[sockets.PINS], info.inputs[0])
        return info.outputs[0]

    def _counts_agree(self, mesh: Socket, result: Socket) -> Socket:
        return self._compare("EQUAL", "INT", self._point_count(mesh), self._point_count(result))

    def _take_positions(self, mesh: Socket, result: Socket) -> Socket:
        if can_transfer():
            transfer = self._node("GeometryNodeTransferAttributes")
            # All but none: the result has positions only.
            transfer.inputs["Exclude Names"].default_value = True
            self._link(mesh, transfer.inputs["Target"])
            self._link(result, transfer.inputs["Source"])
            return transfer.outputs[0]
        sample = self._node("GeometryNodeSampleIndex", data_type="FLOAT_VECTOR")
        self._link(result, sample.inputs["Geometry"])
        self._link(self._node("GeometryNodeInputPosition").outputs[0], sample.inputs["Value"])
        self._link(self._node("GeometryNodeInputIndex").outputs[0], sample.inputs["Index"])
        move = self._node("GeometryNodeSetPosition")
        self._link(mesh, move.inputs["Geometry"])
        self._link(sample.outputs[0], move.inputs["Position"])
        return move.outputs[0]

    def _every_input_used(self) -> Socket:
        """True always, through every input that only the add-on reads: Blender greys out what reaches no output."""
        total: Socket | float = 0.0
        for name in (*NUMBERS, *SWITCHES):
            total = self._floats("ADD", total, self._inputs.outputs[name])
        for name in sockets.MENUS:
            total = self._floats("ADD", total, self._menu_number(name))
        length = self._node("ShaderNodeVectorMath", operation="LENGTH")
        self._link(self._inputs.outputs["Axes"], length.inputs[0])
        total = self._floats("ADD", total, length.outputs["Value"])
        for name in (sockets.STIFFNESS, sockets.WEIGHTS):
            total = self._floats("ADD", total, self._length(name))
        for geometry in (*map(self._object_geometry, (sockets.LATTICE, sockets.FRAME)), self._pins_geometry()):
            total = self._floats("ADD", total, self._point_count(geometry))
        return self._compare("EQUAL", "FLOAT", self._floats("MULTIPLY", total, 0.0), 0.0)

    def _menu_number(self, name: str) -> Socket:
        switch = self._node("GeometryNodeMenuSwitch", data_type="FLOAT")
        for item, text in zip(switch.enum_items, sockets.MENUS[name], strict=False):
            item.name = text
        for text in sockets.MENUS[name][len(switch.enum_items) :]:
            switch.enum_items.new(text)
        self._link(self._inputs.outputs[name], switch.inputs[0])
        return switch.outputs[0]

    def _store(self, mesh: Socket, prefix: str, data_type: str, value: Socket) -> Socket:
        join = self._node("GeometryNodeStringJoin")
        self._link(self._inputs.outputs[sockets.SLOT], join.inputs["Strings"])
        begin = self._node("FunctionNodeInputString")
        begin.string = prefix
        self._link(begin.outputs[0], join.inputs["Strings"])
        store = self._node("GeometryNodeStoreNamedAttribute", data_type=data_type, domain="POINT")
        self._link(mesh, store.inputs["Geometry"])
        self._link(join.outputs[0], store.inputs["Name"])
        self._link(value, store.inputs["Value"])
        return store.outputs[0]

    def _point_count(self, geometry: Socket) -> Socket:
        size = self._node("GeometryNodeAttributeDomainSize", component="MESH")
        self._link(geometry, size.inputs[0])
        return size.outputs["Point Count"]

    def _floats(self, operation: str, one: Socket | float, other: Socket | float) -> Socket:
        return self._operation(self._node("ShaderNodeMath", operation=operation), one, other)

    def _integers(self, operation: str, one: Socket | int, other: Socket | int) -> Socket:
        return self._operation(self._node("FunctionNodeIntegerMath", operation=operation), one, other)

    def _compare(self, operation: str, data_type: str, one: Socket | float, other: Socket | float) -> Socket:
        return self._operation(self._node("FunctionNodeCompare", data_type=data_type, operation=operation), one, other)

    def _operation(self, node: bpy.types.Node, one: Socket | float, other: Socket | float) -> Socket:
        places = [socket for socket in node.inputs if socket.enabled and not socket.is_unavailable]
        for value, place in zip((one, other), places, strict=False):
            if isinstance(value, bpy.types.NodeSocket):
                self._link(value, place)
            else:
                place.default_value = value
        return node.outputs[0]

    def _switch(self, input_type: str, choice: Socket, true: Socket, false: Socket) -> Socket:
        switch = self._node("GeometryNodeSwitch", input_type=input_type)
        for value, place in zip((choice, true, false), ("Switch", "True", "False"), strict=True):
            self._link(value, switch.inputs[place])
        return switch.outputs[0]

    def _node(self, kind: str, **properties: str) -> bpy.types.Node:
        node = self._group.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def _link(self, source: Socket, target: Socket) -> None:
        self._group.links.new(source, target)
