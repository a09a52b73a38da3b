# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that store what enters the modifier in attributes of the points, so that the evaluated geometry carries it."""

import bpy

from . import sockets
from .node_layer import Layer, Socket

INCOMING = ".isochor_incoming_"
"""Point, vector: positions that entered. A leading dot hides an attribute in Blender's lists; the slot follows."""
MARKS = {"MESH": "", "CURVE": "c", "POINTCLOUD": "p"}
"""What stands before the slot, by kind of geometry: modifiers that follow may make curves of a mesh, with its marks."""
LEFT, RIGHT = ".isochor_left_", ".isochor_right_"
"""Point, vector: handles of Bézier curves that entered; of other curves among such their points again."""
ORDER = ".isochor_order_"
"""Point, integer: number of points that entered less the point's index, which proves that none is lost or moved."""
MASK = ".isochor_mask_"
"""Point, float: weight of the vertex group, inverted where asked; stored only where a group is named."""

REGION = ".isochor_region_"
"""Point, float: weight of the vertex group whose part keeps a volume of its own; stored only where one is named."""


class Incoming(Layer):
    """Lays such nodes."""

    def __init__(self, group: bpy.types.NodeTree) -> None:
        super().__init__(group)
        self.inputs = self.node("NodeGroupInput")

    def store_incoming(self, geometry: Socket, component: str = "MESH") -> Socket:
        """The geometry, of one kind, with what entered in attributes."""
        position = self.node("GeometryNodeInputPosition").outputs[0]
        mark = MARKS[component]
        geometry = self.store(geometry, INCOMING + mark, "FLOAT_VECTOR", position)
        index = self.node("GeometryNodeInputIndex").outputs[0]
        order = self.integers("SUBTRACT", self.point_count(geometry, component), index)
        geometry = self.store(geometry, ORDER + mark, "INT", order)
        geometry = self._store_where_named("Vertex Group", geometry, MASK + mark, self._mask())
        return self._store_where_named(sockets.REGION, geometry, REGION + mark, self._weight(sockets.REGION))

    def store(self, geometry: Socket, prefix: str, data_type: str, value: Socket) -> Socket:
        """The geometry with an attribute of its points, whose name is the prefix and the modifier's slot."""
        join = self.node("GeometryNodeStringJoin")
        self.link(self.inputs.outputs[sockets.SLOT], join.inputs["Strings"])
        begin = self.node("FunctionNodeInputString")
        begin.string = prefix
        self.link(begin.outputs[0], join.inputs["Strings"])
        store = self.node("GeometryNodeStoreNamedAttribute", data_type=data_type, domain="POINT")
        self.link(geometry, store.inputs["Geometry"])
        self.link(join.outputs[0], store.inputs["Name"])
        self.link(value, store.inputs["Value"])
        return store.outputs[0]

    def point_count(self, geometry: Socket, component: str = "MESH") -> Socket:
        """Points of one kind, as Blender names it: MESH, CURVE, POINTCLOUD."""
        size = self.node("GeometryNodeAttributeDomainSize", component=component)
        self.link(geometry, size.inputs[0])
        return size.outputs["Point Count"]

    def length(self, name: str) -> Socket:
        """Letters of the text input of this name."""
        length = self.node("FunctionNodeStringLength")
        self.link(self.inputs.outputs[name], length.inputs[0])
        return length.outputs[0]

    def _store_where_named(self, name: str, geometry: Socket, prefix: str, value: Socket) -> Socket:
        """Stores a number a point where the text input of this name is not empty."""
        some = self.compare("GREATER_THAN", "INT", self.length(name), 0)
        return self.switch("GEOMETRY", some, self.store(geometry, prefix, "FLOAT", value), geometry)

    def _mask(self) -> Socket:
        weight = self._weight("Vertex Group")
        return self.switch("FLOAT", self.inputs.outputs["Invert"], self.floats("SUBTRACT", 1.0, weight), weight)

    def _weight(self, name: str) -> Socket:
        """Weight of each point in the vertex group, or attribute, that the input of this name names."""
        weight = self.node("GeometryNodeInputNamedAttribute", data_type="FLOAT")
        self.link(self.inputs.outputs[name], weight.inputs["Name"])
        return weight.outputs["Attribute"]
