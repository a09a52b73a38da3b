# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.squash_from_ground: a driver that presses a mesh flat where it would go through the ground."""

import bpy
import numpy as np

from ..core.settings import AXES, PIVOTS
from ..core.words import Sentence
from ..tool import drivers, lattice_frame, sockets
from ..tool.drivers import Variable
from .driving import Driving, Pairs, Refused, no_lattice, refuse_taken, search_objects, target

PIVOT_ITEMS = (
    ("CENTRE", "Centre", "The middle keeps its place; bottom and top come nearer"),
    ("TOP", "Top", "The end away from the ground keeps its place"),
)
SURFACE_ITEMS = (
    ("TOP", "Top", "Where the ground object is highest now, as of a plane or a slab"),
    ("ORIGIN", "Origin", "The height of its origin"),
)
UPRIGHT = 0.9
"""Least cosine between the vertical and the lattice's axis: some 25 degrees."""


class ISOCHOR_OT_squash_from_ground(Driving, bpy.types.Operator):
    """Drive Squash from the height above a ground object: whatever would go through the ground is pressed together
    just so far that the mesh stands on it"""

    bl_idname = "isochor.squash_from_ground"
    bl_label = "Squash from Ground"
    asks_for = ("ground", ())
    moves = True

    ground: bpy.props.StringProperty(
        name="Ground",
        description="The ground object; empty takes the selected one",
        search=search_objects,
        options={"SKIP_SAVE"},
    )
    surface: bpy.props.EnumProperty(name="Surface", description="Height of the ground", items=SURFACE_ITEMS)
    pivot: bpy.props.EnumProperty(name="Pivot", description="What keeps its place in the squash", items=PIVOT_ITEMS)
    least: bpy.props.FloatProperty(
        name="Least", description="The squash goes no further than this factor", default=0.2, min=0.01, max=1.0
    )
    stay_on_ground: bpy.props.BoolProperty(
        name="Stay on Ground",
        description="Have the volume's correction act sideways only, so that it does not lift or sink the mesh",
        default=True,
    )

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        refuse_taken(pairs, (sockets.SQUASH,), self.replace)
        ground = target(context, self.ground, pairs, "Ground")
        self.ground = ground.name
        depsgraph = context.evaluated_depsgraph_get()
        plans = [plan(obj, modifier, depsgraph, self.pivot) for obj, modifier in pairs]
        offset = ground_offset(ground.evaluated_get(depsgraph)) if self.surface == "TOP" else 0.0
        for (obj, modifier), (axis, pivot, above, below) in zip(pairs, plans, strict=True):
            lattice = sockets.read(modifier, sockets.LATTICE)
            height = Variable("height", lattice, transform="LOC_Z")
            floor = Variable("ground", ground, transform="LOC_Z")
            gap = f"(height - ground {drivers.signed(above - offset)}) / {drivers.number(below)}"
            room = f"max({drivers.number(self.least)}, {gap})"
            sockets.write(modifier, "Axis", AXES[axis])
            sockets.write(modifier, "Pivot", pivot)
            if self.stay_on_ground:
                sockets.write(modifier, "Space", "Global")
                sockets.write(modifier, "Axes", (1.0, 1.0, 0.0))
            drivers.put(obj, modifier, sockets.SQUASH, room, [height, floor], shares=True, at_most="1")


def plan(
    obj: bpy.types.Object, modifier: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph, pivot: str
) -> tuple[int, str, float, float]:
    """The lattice's most upright axis, the name of its end that is the pivot, the pivot's height above the lattice's
    origin, and the pivot's height above the lowest vertex that enters, in world units."""
    frame = lattice_frame.of(modifier, depsgraph)
    if frame is None:
        raise Refused(no_lattice(obj.name))
    heights = np.array([frame.direction(axis)[2] for axis in range(3)])
    axis = int(np.argmax(np.abs(heights)))
    if abs(heights[axis]) < UPRIGHT:
        raise Refused(
            Sentence(
                "No axis of the lattice of “{name}” is upright: turn it, or fit it again with Fit set to World",
                name=obj.name,
            )
        )
    place = 0.5 if pivot == "CENTRE" else float(heights[axis] > 0.0)
    point = frame.end(axis, place)
    points = lattice_frame.entering(obj, modifier, depsgraph)
    below = float(point[2] - points[:, 2].min()) if len(points) else 0.0
    if below <= 1e-6 * float(frame.lengths[axis]):
        raise Refused(
            Sentence(
                "“{name}” has nothing below the pivot that could be squashed: fit its lattice again", name=obj.name
            )
        )
    return axis, PIVOTS[round(2 * place)], float(point[2] - frame.matrix[2, 3]), below


def ground_offset(ground: bpy.types.Object) -> float:
    """Height of the highest corner of an object's bounding box above its origin, in the world."""
    if ground.type == "EMPTY":
        return 0.0
    corners = np.array([tuple(corner) for corner in ground.bound_box], np.float64)
    matrix = np.array(ground.matrix_world, np.float64)
    return float((corners @ matrix[:3, :3].T)[:, 2].max())


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_squash_from_ground)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_squash_from_ground)
