# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes for what is not a mesh alone: curves, hair, point clouds, and whatever modifiers join with them.

The result holds the vertices, then the control points of curves, then, where there are Bézier curves, the left and the
right handle of every control point, then the points of the cloud. Each kind takes its own from there.
"""

from .incoming_nodes import LEFT, RIGHT, Incoming
from .node_layer import Socket
from .own_points import BEZIER

KINDS = {"MESH": "Mesh", "CURVE": "Curve", "POINTCLOUD": "Point Cloud"}
"""Kinds of geometry with points, as Blender's nodes name them, and where they come out of Separate Components."""
UNTOUCHED = ("Grease Pencil", "Volume", "Instances")
"""Others that come out there, and go on as they are."""


class OtherPoints:
    """Lays such nodes with a builder."""

    def __init__(self, builder: Incoming) -> None:
        self._on = builder

    def count(self, geometry: Socket) -> Socket:
        """Points that are not vertices."""
        return self._on.integers(
            "ADD", self._on.point_count(geometry, "CURVE"), self._on.point_count(geometry, "POINTCLOUD")
        )

    def moved(self, geometry: Socket, result: Socket) -> Socket:
        """The geometry with the positions of the result, where the numbers of points agree."""
        on = self._on
        separate = on.node("GeometryNodeSeparateComponents")
        on.link(geometry, separate.inputs[0])
        kinds = {kind: on.store_incoming(separate.outputs[name], kind) for kind, name in KINDS.items()}
        with_bezier = self._with_bezier(kinds["CURVE"])
        kinds["CURVE"] = on.switch("GEOMETRY", with_bezier, self._store_handles(kinds["CURVE"]), kinds["CURVE"])
        vertices, points, cloud = (on.point_count(kinds[kind], kind) for kind in KINDS)
        left = on.integers("ADD", vertices, points)
        right = on.integers("ADD", left, points)
        behind = on.switch("INT", with_bezier, on.integers("ADD", right, points), left)
        moved = {
            "MESH": self._take(kinds["MESH"], result, 0),
            "CURVE": self._take(kinds["CURVE"], result, vertices),
            "POINTCLOUD": self._take(kinds["POINTCLOUD"], result, behind),
        }
        handled = self._take_handles(moved["CURVE"], result, {"left": left, "right": right})
        moved["CURVE"] = on.switch("GEOMETRY", with_bezier, handled, moved["CURVE"])
        fits = on.compare("EQUAL", "INT", on.integers("ADD", behind, cloud), on.point_count(result))
        one, other = ([found[kind] for kind in KINDS] for found in (moved, kinds))
        chosen = [on.switch("GEOMETRY", fits, *pair) for pair in zip(one, other, strict=True)]
        return self._joined([*chosen, *(separate.outputs[name] for name in UNTOUCHED)])

    def _with_bezier(self, curves: Socket) -> Socket:
        """Whether there is a Bézier curve."""
        on = self._on
        statistic = on.node("GeometryNodeAttributeStatistic", data_type="FLOAT", domain="CURVE")
        on.link(curves, statistic.inputs["Geometry"])
        on.link(self._is_bezier(), statistic.inputs["Attribute"])
        return on.compare("GREATER_THAN", "FLOAT", statistic.outputs["Max"], 0.5)

    def _is_bezier(self) -> Socket:
        return self._on.compare("EQUAL", "INT", self._named("curve_type", "INT"), BEZIER)

    def _named(self, name: str, data_type: str) -> Socket:
        named = self._on.node("GeometryNodeInputNamedAttribute", data_type=data_type)
        named.inputs["Name"].default_value = name
        return named.outputs["Attribute"]

    def _store_handles(self, curves: Socket) -> Socket:
        on = self._on
        position = on.node("GeometryNodeInputPosition").outputs[0]
        for side, prefix in (("left", LEFT), ("right", RIGHT)):
            handle = self._named(f"handle_{side}", "FLOAT_VECTOR")
            curves = on.store(curves, prefix, "FLOAT_VECTOR", on.switch("VECTOR", self._is_bezier(), handle, position))
        return curves

    def _take(self, geometry: Socket, result: Socket, first: Socket | int) -> Socket:
        """The geometry of one kind with the positions of the result from the point ``first`` on."""
        move = self._on.node("GeometryNodeSetPosition")
        self._on.link(geometry, move.inputs["Geometry"])
        self._on.link(self._sampled(result, first), move.inputs["Position"])
        return move.outputs[0]

    def _take_handles(self, curves: Socket, result: Socket, first: dict[str, Socket]) -> Socket:
        """After the points, which take handles along; free ones, so that none is worked out anew from the points."""
        on = self._on
        for side, begin in first.items():
            store = on.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT_VECTOR", domain="POINT")
            store.inputs["Name"].default_value = f"handle_{side}"
            on.link(curves, store.inputs["Geometry"])
            on.link(self._sampled(result, begin), store.inputs["Value"])
            curves = store.outputs[0]
        free = on.node("GeometryNodeCurveSetHandles", handle_type="FREE")
        free.mode = {"LEFT", "RIGHT"}
        on.link(curves, free.inputs["Curve"])
        return free.outputs[0]

    def _sampled(self, result: Socket, first: Socket | int) -> Socket:
        on = self._on
        sample = on.node("GeometryNodeSampleIndex", data_type="FLOAT_VECTOR")
        on.link(result, sample.inputs["Geometry"])
        on.link(on.node("GeometryNodeInputPosition").outputs[0], sample.inputs["Value"])
        index = on.node("GeometryNodeInputIndex").outputs[0]
        on.link(on.integers("ADD", index, first), sample.inputs["Index"])
        return sample.outputs[0]

    def _joined(self, geometries: list[Socket]) -> Socket:
        """All of them; of a kind that only one has, that one itself."""
        join = self._on.node("GeometryNodeJoinGeometry")
        for geometry in geometries:
            self._on.link(geometry, join.inputs[0])
        return join.outputs[0]
