# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's sub-panel "Physics"."""

import bpy

from ..core.words import Sentence
from ..tool import words
from .simulating import ISOCHOR_OT_free_simulation, ISOCHOR_OT_simulate, simulated_lattices


class VIEW3D_PT_isochor_physics(bpy.types.Panel):
    """Simulating the lattice as jelly"""

    bl_label = "Physics"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "VIEW3D_PT_isochor"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 12

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        for lattice in simulated_lattices(context):
            frames = len(lattice.data.shape_keys.key_blocks) if lattice.data.shape_keys is not None else 0
            text = Sentence("{name}: {count} frames", name=lattice.name, count=frames)
            layout.label(text=words.shown(text), translate=False, icon="PHYSICS")
        column = layout.column(align=True)
        column.operator(ISOCHOR_OT_simulate.bl_idname, icon="PHYSICS")
        column.operator(ISOCHOR_OT_free_simulation.bl_idname, icon="LOOP_BACK")


def register() -> None:
    """Adds the panel."""
    bpy.utils.register_class(VIEW3D_PT_isochor_physics)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor_physics)
