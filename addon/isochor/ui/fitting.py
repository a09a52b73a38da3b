# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator isochor.fit_lattice."""

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.fit import axes_of, box_matrix
from ..tool import control, lattices, refining, refit, words
from .adding import FIT_ITEMS, fitted_axes
from .choosing import chosen_modifiers

KEEP = ("KEEP", "As It Stands", "Along the axes that the lattice has")


class ISOCHOR_OT_fit_lattice(bpy.types.Operator):
    """Move and size the lattice so that it fits its meshes again, as after modelling. Its points stay where they are
    in the box, so the deformation stays; the volume that enters now becomes the rest volume"""

    bl_idname = "isochor.fit_lattice"
    bl_label = "Fit Lattice Again"
    bl_options = {"REGISTER", "UNDO"}

    fit: bpy.props.EnumProperty(
        name="Fit", description="Which way the box of the lattice stands", items=(KEEP, *FIT_ITEMS)
    )
    margin: bpy.props.FloatProperty(
        name="Margin",
        description="Room on each side, as a fraction of the box's size",
        default=0.05,
        min=0.0,
        soft_max=1.0,
    )
    resolution: bpy.props.IntVectorProperty(
        name="Resolution",
        description="Points of the lattice on each axis, more than it has, with the same deformation; 0 leaves them",
        default=(0, 0, 0),
        min=0,
        max=64,
        size=3,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set("Select a mesh with a Volume Lattice, or its lattice, first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        named = list(dict.fromkeys(lattices.of(modifier) for _obj, modifier in chosen_modifiers(context)))
        places, finer = [], {}
        try:
            for lattice in named:
                if lattice is None:
                    raise problem.Problem(problem.NO_LATTICE)
                users = lattices.users_of(lattice)
                refit.refuse(lattice, users)
                if self._shape(lattice) != control.shape(lattice):
                    finer[lattice.data.name] = refining.plan(lattice, self._shape(lattice))
                places.append((lattice, users, self._matrix(lattice, users, context)))
            refit.move([(lattice, matrix) for lattice, _, matrix in places], context)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        for plan in finer.values():
            refining.apply(plan, context)
        refit.measure_again([user for _, users, _ in places for user in users], context)
        return {"FINISHED"}

    def _shape(self, lattice: bpy.types.Object) -> tuple[int, int, int]:
        """Points that the lattice is to have."""
        u, v, w = (new or old for new, old in zip(self.resolution, control.shape(lattice), strict=True))
        return u, v, w

    def _matrix(
        self, lattice: bpy.types.Object, users: list[refit.User], context: bpy.types.Context
    ) -> NDArray[np.float64]:
        """Where the lattice belongs, to world."""
        points = refit.world_points(users, context)
        present = np.array(lattice.matrix_world, np.float64)
        like = np.array(users[0][0].matrix_world, np.float64) if self.fit == "LOCAL" else present
        axes = axes_of(present) if self.fit == "KEEP" else fitted_axes(self.fit, points, like)
        if np.linalg.det(present[:3, :3]) < 0.0:
            axes = axes * (1.0, 1.0, -1.0)
        matrix = box_matrix(points, axes, self.margin, control.shape(lattice), refit.basis(users))
        matrix[:3, :3] *= refit.grid_scale(lattice, users)
        return matrix


def register() -> None:
    """Makes the operator known."""
    bpy.utils.register_class(ISOCHOR_OT_fit_lattice)


def unregister() -> None:
    """Takes it back."""
    bpy.utils.unregister_class(ISOCHOR_OT_fit_lattice)
