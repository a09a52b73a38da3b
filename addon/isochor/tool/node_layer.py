# SPDX-License-Identifier: GPL-3.0-or-later
"""Lays nodes into a Geometry Nodes group: the few kinds that ours is made of."""

import bpy

Socket = bpy.types.NodeSocket


class Layer:
    """Adds nodes to one group and links them."""

    def __init__(self, group: bpy.types.NodeTree) -> None:
        self.group = group

    def floats(self, operation: str, one: Socket | float, other: Socket | float) -> Socket:
        return self._operation(self.node("ShaderNodeMath", operation=operation), one, other)

    def integers(self, operation: str, one: Socket | int, other: Socket | int) -> Socket:
        return self._operation(self.node("FunctionNodeIntegerMath", operation=operation), one, other)

    def compare(self, operation: str, data_type: str, one: Socket | float, other: Socket | float) -> Socket:
        return self._operation(self.node("FunctionNodeCompare", data_type=data_type, operation=operation), one, other)

    def _operation(self, node: bpy.types.Node, one: Socket | float, other: Socket | float) -> Socket:
        places = [socket for socket in node.inputs if socket.enabled and not socket.is_unavailable]
        for value, place in zip((one, other), places, strict=False):
            if isinstance(value, bpy.types.NodeSocket):
                self.link(value, place)
            else:
                place.default_value = value
        return node.outputs[0]

    def switch(self, input_type: str, choice: Socket, true: Socket, false: Socket) -> Socket:
        switch = self.node("GeometryNodeSwitch", input_type=input_type)
        for value, place in zip((choice, true, false), ("Switch", "True", "False"), strict=True):
            self.link(value, switch.inputs[place])
        return switch.outputs[0]

    def node(self, kind: str, **properties: str) -> bpy.types.Node:
        node = self.group.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def link(self, source: Socket, target: Socket) -> None:
        self.group.links.new(source, target)
