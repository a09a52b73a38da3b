# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.refine."""

import bpy

from ..core.problem import Problem
from ..core.words import Sentence
from ..tool import refining, words
from .choosing import chosen_lattices


class ISOCHOR_OT_refine(bpy.types.Operator):
    """Give the lattice more points with the very same deformation: shape keys with their animation, and vertex groups,
    are carried over"""

    bl_idname = "isochor.refine"
    bl_label = "Refine Lattice"
    bl_options = {"REGISTER", "UNDO"}

    resolution: bpy.props.IntVectorProperty(
        name="Resolution",
        description="Points of the lattice on each axis, more than it has; 0 for the next that can deform the same",
        default=(0, 0, 0),
        min=0,
        max=64,
        size=3,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_lattices(context):
            return True
        cls.poll_message_set("Select a mesh with a Volume Lattice, or its lattice, first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        u, v, w = self.resolution
        try:
            plans: dict[str, refining.Plan] = {}
            for lattice in chosen_lattices(context):
                plans.setdefault(lattice.data.name, refining.plan(lattice, (u, v, w)))
            changing = [plan for plan in plans.values() if plan.changes]
            if not changing:
                raise Problem(Sentence("So many points there are already: raise Resolution, or set it to 0."))
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        for plan in changing:
            refining.apply(plan, context)
            for text in plan.warnings:
                self.report({"WARNING"}, words.reported(text))
        return {"FINISHED"}


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_refine)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_refine)
