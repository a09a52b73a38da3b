# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.squash_from_speed: stretch with speed, from the sampled motion of the object."""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.settings import AXES
from ..core.words import Sentence
from ..tool import drivers, lattice_frame, sockets, speed
from ..tool.drivers import Variable
from .driving import Driving, Pairs, Refused, refuse_taken
from .frames import FrameRange

DIRECTION_ITEMS = (
    ("ANY", "Any", "The whole speed, whichever way the object moves"),
    ("AXIS", "Along Axis", "Only the part along the lattice's axis: a ball that flies sideways is not drawn upwards"),
)
STILL = 1e-6
"""Units a second below which an object counts as at rest."""


class ISOCHOR_OT_squash_from_speed(Driving, FrameRange, bpy.types.Operator):
    """Stretch with speed: samples how fast each object moves in the world over the frames, keeps it as keys of its
    property "isochor_speed", and drives Squash from that. Run again after changing the motion"""

    bl_idname = "isochor.squash_from_speed"
    bl_label = "Squash from Speed"
    moves = True

    direction: bpy.props.EnumProperty(name="Direction", description="Which speed counts", items=DIRECTION_ITEMS)
    stretch: bpy.props.FloatProperty(
        name="Stretch",
        description="Squash at full speed: above 1 stretches along the axis, below 1 presses together",
        default=1.5,
        min=0.05,
        soft_max=3.0,
    )
    full_speed: bpy.props.FloatProperty(
        name="Full Speed",
        description="World units a second at which the stretch is whole; 0 takes the fastest of these frames",
        default=0.0,
        min=0.0,
        options={"SKIP_SAVE"},
    )

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        refuse_taken(pairs, (sockets.SQUASH,), self.replace)
        for obj, _modifier in pairs:
            refuse_unkeyable(obj)
        start, end = self.take_frames(context.scene)
        speeds = self.speeds(context, pairs, start, end)
        for (obj, _modifier), found in zip(pairs, speeds, strict=True):
            if found.max() <= STILL:
                raise Refused(
                    Sentence(
                        "“{name}” does not move in frames {start} to {end}: animate its place first",
                        name=obj.name,
                        start=start,
                        end=end,
                    )
                )
        for (obj, modifier), found in zip(pairs, speeds, strict=True):
            speed.keep(obj, start, found)
            full = self.full_speed or float(found.max())
            expression = f"lerp(1, {drivers.number(self.stretch)}, min(1, speed / {drivers.number(full)}))"
            given = [Variable("speed", obj, speed.PATH)]
            drivers.put(obj, modifier, sockets.SQUASH, expression, given, shares=True)
        context.view_layer.update()

    def speeds(self, context: bpy.types.Context, pairs: Pairs, start: int, end: int) -> list[NDArray[np.float64]]:
        """(F,) world units a second of each object, frame by frame."""
        rate = context.scene.render.fps / context.scene.render.fps_base
        samples = [sample(obj, modifier) for obj, modifier in pairs]
        found = []
        for rows in speed.sampled(context, start - 1, end + 1, samples):
            velocity = speed.velocities(rows[:, 0], rate)
            along = np.abs(np.einsum("ij,ij->i", velocity, rows[1:-1, 1]))
            found.append(along if self.direction == "AXIS" else np.linalg.norm(velocity, axis=1))
        return found


def sample(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> speed.Sample:
    """What is read in every frame: (2, 3) the object's place in the world and the direction of the lattice's axis."""

    def read(depsgraph: bpy.types.Depsgraph) -> NDArray[np.float64]:
        place = np.array(obj.evaluated_get(depsgraph).matrix_world.translation, np.float64)
        frame = lattice_frame.of(modifier, depsgraph)
        axis = AXES.index(sockets.read(modifier, "Axis"))
        return np.stack([place, np.zeros(3) if frame is None else frame.direction(axis)])

    return read


def refuse_unkeyable(obj: bpy.types.Object) -> None:
    """Raises Refused where the object's keys belong to another file, it cannot keep its speed, or that is driven."""
    if obj.override_library is not None:
        raise Refused(
            Sentence("“{name}” is a library override, which cannot keep its speed: make it local first", name=obj.name)
        )
    action = obj.animation_data.action if obj.animation_data is not None else None
    if action is not None and not action.is_editable:
        raise Refused(
            Sentence("The keys of “{name}” come from another file: make its action local first", name=obj.name)
        )
    if drivers.of(obj, speed.PATH) is not None:
        raise Refused(
            Sentence(
                "The property {property} of “{name}” has a driver: delete it first",
                property=speed.PROPERTY,
                name=obj.name,
            )
        )


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_squash_from_speed)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_squash_from_speed)
