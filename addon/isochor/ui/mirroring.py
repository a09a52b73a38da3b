# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.mirror_lattice."""

import bpy
import numpy as np

from ..core import problem
from ..core.mirror import mirrored
from ..tool import baked_lattice, control, words
from .choosing import chosen_lattices

AXES = (
    ("X", "X", "Left and right of the lattice, along its own X"),
    ("Y", "Y", "Front and back of the lattice, along its own Y"),
    ("Z", "Z", "Bottom and top of the lattice, along its own Z"),
)
DIRECTIONS = (
    ("POSITIVE_TO_NEGATIVE", "Positive to Negative", "The side of larger coordinates is the model"),
    ("NEGATIVE_TO_POSITIVE", "Negative to Positive", "The side of smaller coordinates is the model"),
)


class ISOCHOR_OT_mirror_lattice(bpy.types.Operator):
    """Give one side of each selected lattice the mirror image of the other side's deformation, on the active shape key
    where there is one. A middle layer of points is put onto the mirror plane"""

    bl_idname = "isochor.mirror_lattice"
    bl_label = "Mirror Lattice"
    bl_options = {"REGISTER", "UNDO"}

    axis: bpy.props.EnumProperty(name="Axis", description="Which two sides of the lattice", items=AXES)
    direction: bpy.props.EnumProperty(name="Direction", description="Which side is copied", items=DIRECTIONS)
    only_selected: bpy.props.BoolProperty(
        name="Only Selected",
        description="In the lattice's Edit Mode: only pairs of points of which one is selected",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_lattices(context):
            return True
        cls.poll_message_set("Select a lattice, or a mesh with a Volume Lattice, first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        lattices = list({lattice.data: lattice for lattice in chosen_lattices(context)}.values())
        try:
            for lattice in lattices:
                self._refuse(lattice)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        for lattice in lattices:
            chosen = control.selected(lattice) if self._only_selected(lattice) else None
            points = control.read(lattice)
            to_positive = self.direction == "NEGATIVE_TO_POSITIVE"
            control.write(
                lattice, mirrored(points, control.shape(lattice), "XYZ".index(self.axis), to_positive, chosen)
            )
        return {"FINISHED"}

    def _only_selected(self, lattice: bpy.types.Object) -> bool:
        return self.only_selected and lattice.data.is_editmode

    def _refuse(self, lattice: bpy.types.Object) -> None:
        """Raises ``Problem`` where this lattice cannot be mirrored."""
        control.refuse_if_locked(lattice)
        if baked_lattice.is_baked(lattice):
            raise problem.Problem(problem.simulated(lattice.name))
        if control.shape(lattice)["XYZ".index(self.axis)] == 1:
            raise problem.Problem(problem.no_sides(lattice.name, self.axis))
        if self._only_selected(lattice) and not np.any(control.selected(lattice)):
            raise problem.Problem(problem.nothing_selected(lattice.name))


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_mirror_lattice)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_mirror_lattice)
