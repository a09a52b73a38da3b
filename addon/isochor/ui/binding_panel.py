# SPDX-License-Identifier: GPL-3.0-or-later
"""The part "Bind" of the sidebar tab: which lattices have their rest set."""

import bpy

from ..core.words import Sentence, named
from ..tool import bound, results
from .binding import ISOCHOR_OT_clear_rest, ISOCHOR_OT_set_rest
from .choosing import chosen_modifiers
from .sidebar import VIEW3D_PT_isochor, draw_text, line_width


class VIEW3D_PT_isochor_bind(bpy.types.Panel):
    """From where the lattice's shape and place are measured"""

    bl_label = "Bind"
    bl_parent_id = VIEW3D_PT_isochor.__name__
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        for obj, modifier in chosen_modifiers(context):
            icon = "LINKED" if bound.bound_with(results.of(modifier, "VIEWPORT")) else "UNLINKED"
            draw_text(column, named(obj.name, state_of(modifier)), icon, line_width(context))
        row = self.layout.row(align=True)
        row.operator(ISOCHOR_OT_set_rest.bl_idname, icon="LINKED")
        row.operator(ISOCHOR_OT_clear_rest.bl_idname, icon="UNLINKED")


def state_of(modifier: bpy.types.NodesModifier) -> str:
    """Whether the modifier's rest is set, and with what, in plain words."""
    found = bound.bound_with(results.of(modifier, "VIEWPORT"))
    if found is None:
        return Sentence("not bound; the lattice's undeformed box counts as its rest")
    name, shape = found
    return Sentence("bound with “{name}”, {shape} points", name=name, shape="×".join(map(str, shape)))


def register() -> None:
    """Adds the panel."""
    bpy.utils.register_class(VIEW3D_PT_isochor_bind)


def unregister() -> None:
    """Takes it away."""
    bpy.utils.unregister_class(VIEW3D_PT_isochor_bind)
