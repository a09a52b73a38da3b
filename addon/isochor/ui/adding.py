# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.add."""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.fit import axes_of, box_matrix
from ..core.oriented import oriented_axes
from ..tool import adding, words
from .choosing import chosen_objects

BASIS_ITEMS = (
    ("BERNSTEIN", "Bernstein", "Every control point reaches everywhere, smoothly"),
    (
        "BSPLINE",
        "B-Spline",
        "Each control point reaches its neighbourhood; the lattice is one layer larger on each side",
    ),
)
FIT_ITEMS = (
    ("LOCAL", "Local", "Along the active object's axes"),
    ("ORIENTED", "Oriented", "The smallest box, whichever way it stands"),
    ("WORLD", "World", "Along the world's axes"),
)


class ISOCHOR_OT_add(bpy.types.Operator):
    """Fit a lattice to the selected meshes and deform them with it, keeping their volume. Turns on Lock Interface in
    the Render menu, because the viewport must not be edited while a render runs"""

    bl_idname = "isochor.add"
    bl_label = "Add Volume Lattice"
    bl_options = {"REGISTER", "UNDO"}

    resolution: bpy.props.IntVectorProperty(
        name="Resolution", description="Points of the lattice on each axis", default=(4, 4, 4), min=1, max=64, size=3
    )
    basis: bpy.props.EnumProperty(name="Basis", description="How control points blend", items=BASIS_ITEMS)
    fit: bpy.props.EnumProperty(name="Fit", description="Which way the box of the lattice stands", items=FIT_ITEMS)
    margin: bpy.props.FloatProperty(
        name="Margin",
        description="Room on each side, as a fraction of the box's size",
        default=0.05,
        min=0.0,
        soft_max=1.0,
    )

    follow: bpy.props.BoolProperty(
        name="Follow Object",
        description="Make the lattice a child of the active object, so that it moves along with it",
    )

    only_last: bpy.props.BoolProperty(
        name="Only the Last Corrects",
        description="Where the mesh has a Volume Lattice already: the new one, behind it, takes over how the volume is"
        " kept, for both of them, and the one before it only deforms",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_objects(context):
            return True
        cls.poll_message_set("Select a mesh object first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = chosen_objects(context)
        foreign = [obj.name for obj in objects if not obj.is_editable]
        if foreign:
            self.report({"ERROR"}, words.reported(problem.foreign(", ".join(foreign))))
            return {"CANCELLED"}
        points = np.concatenate([adding.world_points(obj, context) for obj in objects])
        if not len(points):
            self.report({"ERROR"}, problem.NO_POINTS)
            return {"CANCELLED"}
        if not np.isfinite(points).all():
            self.report({"ERROR"}, problem.NO_PLACE)
            return {"CANCELLED"}
        shape = tuple(self.resolution)
        axes = fitted_axes(self.fit, points, np.array(objects[0].matrix_world))
        matrix = box_matrix(points, axes, self.margin, shape, self.basis)
        lattice = adding.new_lattice(f"{objects[0].name} Lattice", shape, matrix, context, objects[0])
        if self.follow:
            adding.make_child(lattice, objects[0])
        if adding.lock_interface(context.scene):
            self.report({"INFO"}, "Lock Interface is now on in the Render menu: renders need it")
        problems = adding.add_modifiers(objects, lattice, self.basis, context, self.only_last)
        for text in problems:
            self.report({"WARNING"}, words.reported(text))
        return {"FINISHED"}


def fitted_axes(fit: str, points: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Directions of the lattice's box, as columns, for one of FIT_ITEMS and the active object's matrix to world."""
    if fit == "WORLD":
        return np.eye(3)
    return oriented_axes(points, axes_of(matrix)) if fit == "ORIENTED" else axes_of(matrix)


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_add)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_add)
