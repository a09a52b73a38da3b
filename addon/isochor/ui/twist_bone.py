# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.twist_from_bone: a driver that twists a mesh as a bone rolls."""

import bpy
import numpy as np

from ..core.settings import AXES
from ..core.words import Sentence
from ..tool import drivers, lattice_frame, sockets
from ..tool.drivers import Variable
from .driving import Driving, Pairs, Refused, refuse_taken, search_objects, target

AXIS_ITEMS = (
    ("X", "X", "The bone's turn about its X axis"),
    ("Y", "Y", "Its roll, about its length"),
    ("Z", "Z", "The bone's turn about its Z axis"),
)


class ISOCHOR_OT_twist_from_bone(Driving, bpy.types.Operator):
    """Drive Twist from the rotation of a bone about one of its own axes, up to half a turn either way, in the sense in
    which the bone turns"""

    bl_idname = "isochor.twist_from_bone"
    bl_label = "Twist from Bone"
    asks_for = ("armature", ("ARMATURE",))

    armature: bpy.props.StringProperty(
        name="Armature",
        description="The armature object; empty takes the selected one",
        search=search_objects,
        options={"SKIP_SAVE"},
    )
    bone: bpy.props.StringProperty(
        name="Bone", description="The bone; empty takes the active one of the armature", options={"SKIP_SAVE"}
    )
    axis: bpy.props.EnumProperty(name="Axis", description="The bone's axis", items=AXIS_ITEMS, default="Y")
    factor: bpy.props.FloatProperty(name="Factor", description="Twist for each turn of the bone", default=1.0)

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        refuse_taken(pairs, (sockets.TWIST,), self.replace)
        armature = target(context, self.armature, pairs, "Armature", ("ARMATURE",))
        bone = bone_of(armature, self.bone)
        self.armature, self.bone = armature.name, bone
        depsgraph = context.evaluated_depsgraph_get()
        factors = [self.factor * sense(modifier, armature, bone, self.axis, depsgraph) for _obj, modifier in pairs]
        for (obj, modifier), factor in zip(pairs, factors, strict=True):
            roll = Variable("roll", armature, "", f"ROT_{self.axis}", bone, "LOCAL_SPACE", f"SWING_TWIST_{self.axis}")
            drivers.put(obj, modifier, sockets.TWIST, f"roll * {drivers.number(factor)}", [roll])


def bone_of(armature: bpy.types.Object, name: str) -> str:
    """The bone of this name, or without a name the active one."""
    if name:
        if name not in armature.data.bones:
            raise Refused(
                Sentence("Bone: “{armature}” has no bone “{name}”; correct the name", armature=armature.name, name=name)
            )
        return name
    active = armature.data.bones.active
    if active is None:
        raise Refused(
            Sentence(
                "Bone: “{armature}” has no active bone; click one in Pose Mode, or name it", armature=armature.name
            )
        )
    return str(active.name)


def sense(
    modifier: bpy.types.NodesModifier,
    armature: bpy.types.Object,
    bone: str,
    axis: str,
    depsgraph: bpy.types.Depsgraph,
) -> float:
    """1, or -1 where a turn of the bone and a twist of the lattice by the same angle would go opposite ways."""
    frame = lattice_frame.of(modifier, depsgraph)
    if frame is None:
        return 1.0
    number = AXES.index(axis)
    world = np.array(armature.matrix_world, np.float64)[:3, :3]
    bone_axis = world @ np.array(armature.data.bones[bone].matrix_local, np.float64)[:3, number]
    along = float(bone_axis @ frame.direction(AXES.index(sockets.read(modifier, "Axis"))))
    mirrored = np.linalg.det(frame.matrix[:3, :3]) * np.linalg.det(world) < 0.0
    return -1.0 if (along < 0.0) != mirrored else 1.0


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_twist_from_bone)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_twist_from_bone)
