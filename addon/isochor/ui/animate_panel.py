# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Animate" of the sidebar: the inputs to key, and the operators that drive them."""

import bpy

from ..tool import sockets
from .bend_empty import ISOCHOR_OT_bend_from_empty
from .choosing import chosen_modifiers
from .sidebar import VIEW3D_PT_isochor
from .squash_ground import ISOCHOR_OT_squash_from_ground
from .squash_speed import ISOCHOR_OT_squash_from_speed
from .twist_bone import ISOCHOR_OT_twist_from_bone

NUMBERS = (sockets.SQUASH, sockets.TAPER, sockets.TWIST, sockets.BEND, sockets.BEND_DIRECTION)
OPERATORS = (
    (ISOCHOR_OT_squash_from_ground, "MESH_PLANE"),
    (ISOCHOR_OT_twist_from_bone, "BONE_DATA"),
    (ISOCHOR_OT_bend_from_empty, "EMPTY_AXIS"),
    (ISOCHOR_OT_squash_from_speed, "FORCE_FORCE"),
)


class VIEW3D_PT_isochor_animate(bpy.types.Panel):
    """Squash, taper, twist and bend of the chosen Volume Lattices, and ready drivers for them"""

    bl_label = "Animate"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = VIEW3D_PT_isochor.__name__
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 11

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        for obj, modifier in chosen_modifiers(context):
            draw_numbers(layout, obj, modifier)
        column = layout.column(align=True)
        for operator, icon in OPERATORS:
            column.operator(operator.bl_idname, icon=icon)


def draw_numbers(layout: bpy.types.UILayout, obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> None:
    """The numbers of one modifier, as its own panel shows them: keys and drivers can be put here too."""
    known = [name for name in NUMBERS if name in sockets.identifiers(modifier.node_group)]
    column = layout.column(align=True)
    column.label(text=obj.name, icon="MOD_LATTICE", translate=False)
    for name in known:
        owner, path = sockets.property_of(modifier, name)
        column.prop(owner, path, text=name)


def register() -> None:
    """Adds the sub-panel."""
    bpy.utils.register_class(VIEW3D_PT_isochor_animate)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor_animate)
