# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.bend_from_empty: drivers that bend a mesh so that its end points at an empty."""

import bpy
import numpy as np

from ..core.settings import AXES
from ..core.shaping import PLACE_OF_PIVOT, cyclic
from ..tool import adding, drivers, lattice_frame, sockets
from ..tool.drivers import Variable
from ..tool.lattice_frame import LatticeFrame
from .driving import Driving, Pairs, Refused, beside, no_lattice, refuse_taken, search_objects, target

INPUTS = (sockets.BEND, sockets.BEND_DIRECTION)


class ISOCHOR_OT_bend_from_empty(Driving, bpy.types.Operator):
    """Drive Bend and Bend Direction from an empty: the lattice bends from its pivot until its far end lies on the line
    to the empty. Without one selected, it makes one at the far end that goes with the lattice"""

    bl_idname = "isochor.bend_from_empty"
    bl_label = "Bend from Empty"

    empty: bpy.props.StringProperty(
        name="Empty",
        description="The object to bend towards; empty takes the selected one, or makes one where none is selected",
        search=search_objects,
        options={"SKIP_SAVE"},
    )

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        refuse_taken(pairs, INPUTS, self.replace)
        frames = [frame_of(obj, modifier, context) for obj, modifier in pairs]
        makes = not self.empty and not beside(context, pairs, ())
        chosen = None if makes else target(context, self.empty, pairs, "Empty")
        self.empty = chosen.name if chosen is not None else ""
        for (obj, modifier), frame in zip(pairs, frames, strict=True):
            empty = chosen or new_empty(obj, modifier, frame, context)
            bend, direction = expressions(frame, sockets.read(modifier, "Axis"), sockets.read(modifier, "Pivot"))
            lattice = sockets.read(modifier, sockets.LATTICE)
            for name, expression in zip(INPUTS, (bend, direction), strict=True):
                used = drivers.words(expression)
                given = [one for one in variables(empty, lattice, modifier) if one.name in used]
                drivers.put(obj, modifier, name, expression, given)


def frame_of(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, context: bpy.types.Context) -> LatticeFrame:
    """Where the lattice stands now."""
    frame = lattice_frame.of(modifier, context.evaluated_depsgraph_get())
    if frame is None:
        raise Refused(no_lattice(obj.name))
    return frame


def expressions(frame: LatticeFrame, axis: str, pivot: str) -> tuple[str, str]:
    """Of the bend and of its direction, in radians, for an empty at e: a chord of the arc makes half the arc's angle
    with the tangent at its end. From the centre each half of the axis has half of the bend, and so a quarter."""
    along, first, second = cyclic(axis)
    from_top = pivot == "Top"
    height = frame.low[along] + PLACE_OF_PIVOT[pivot] * (frame.high[along] - frame.low[along])
    x = f"{product('a')}/{drivers.number(frame.lengths[first])}"
    y = f"{product('b')}/{drivers.number(frame.lengths[second])}"
    z = f"{product('c', height)}/{drivers.number(-frame.lengths[along] if from_top else frame.lengths[along])}"
    times = 4 if pivot == "Centre" else 2
    return f"{times}*atan2(sqrt(pow({x},2)+pow({y},2)),{z})", f"atan2({y},{x})"


def product(column: str, height: float = 0.0) -> str:
    """Scalar product of a column of the lattice's matrix and the way from its origin, or from the point at ``height``
    on that column, to the empty."""
    less = f"{'-' if height > 0.0 else '+'}{drivers.number(abs(height))}*{column}"
    terms = [f"(e{i}-o{i}{less + i if height else ''})*{column}{i}" for i in "xyz"]
    return f"({'+'.join(terms)})"


def variables(empty: bpy.types.Object, lattice: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[Variable]:
    """e, the empty's place; o, the lattice's; c, its column of the axis; a and b, those of the two that follow."""
    along, first, second = cyclic(sockets.read(modifier, "Axis"))
    sources = (("e", empty, 3), ("o", lattice, 3), ("a", lattice, first), ("b", lattice, second), ("c", lattice, along))
    return [
        Variable(f"{letter}{name}", source, f"matrix_world[{column}][{row}]")
        for letter, source, column in sources
        for row, name in enumerate("xyz")
    ]


def new_empty(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, frame: LatticeFrame, context: bpy.types.Context
) -> bpy.types.Object:
    """An empty at the far end of the axis, which the lattice carries along, in the active collection."""
    along = AXES.index(sockets.read(modifier, "Axis"))
    lattice = sockets.read(modifier, sockets.LATTICE)
    empty = bpy.data.objects.new(f"{obj.name} Bend", None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = float(0.1 * np.mean(frame.lengths))
    adding.open_collection(context, lattice).objects.link(empty)
    empty.parent = lattice
    empty.matrix_parent_inverse = lattice.matrix_world.inverted()
    empty.location = frame.end(along, 0.0 if sockets.read(modifier, "Pivot") == "Top" else 1.0)
    return empty


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_bend_from_empty)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_bend_from_empty)
