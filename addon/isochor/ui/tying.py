# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.tie_lattices and isochor.untie_lattices."""

import bpy

from ..core import problem
from ..core.words import Sentence
from ..tool import lattices, stack, tie_record, tying, words
from .choosing import active_object

CONTINUITY = (
    ("C0", "C0", "Without a gap: the points on the common face stay together"),
    ("C1", "C1", "Without a crease either: the layer of points behind the face follows too"),
)


class ISOCHOR_OT_tie_lattices(bpy.types.Operator):
    """Hold the selected lattices together where their faces coincide: when one of them is edited, its neighbours follow
    at the joint. The active one leads until another is edited"""

    bl_idname = "isochor.tie_lattices"
    bl_label = "Tie Lattices"
    bl_options = {"REGISTER", "UNDO"}

    continuity: bpy.props.EnumProperty(
        name="Continuity", description="How smoothly they join", items=CONTINUITY, default="C1"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if len(tied_together(context)) > 1:
            return True
        cls.poll_message_set("Select two or more lattices, or an object that several shape, first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            made, alone = tying.tie(tied_together(context), int(self.continuity[1]), context)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if alone:
            self.report({"WARNING"}, words.reported(problem.meets_none([lattice.name for lattice in alone])))
        self.report({"INFO"}, words.reported(Sentence("{count} joints tied", count=len(made))))
        return {"FINISHED"}


class ISOCHOR_OT_untie_lattices(bpy.types.Operator):
    """Let go of the selected lattices, each of the others; with one selected, of all that it is tied to. Their points
    stay where they are"""

    bl_idname = "isochor.untie_lattices"
    bl_label = "Untie Lattices"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if any(tie_record.of(lattice) for lattice in tied_together(context)):
            return True
        cls.poll_message_set("None of the selected lattices is tied")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            gone = tying.untie(tied_together(context), context)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if not gone:
            self.report({"WARNING"}, "The selected lattices are not tied to one another")
        return {"FINISHED"}


def tied_together(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active and the selected lattices, and all that shape an active or selected mesh, each once."""
    active = active_object(context)
    found = []
    for obj in [active, *context.view_layer.objects.selected]:
        if obj is not None and obj.type == "LATTICE":
            found.append(obj)
        elif obj is not None and obj.type in stack.DEFORMED:
            found += lattices.of_all([(obj, modifier) for modifier in stack.ours(obj)])
    return list(dict.fromkeys(found))


CLASSES = (ISOCHOR_OT_tie_lattices, ISOCHOR_OT_untie_lattices)


def register() -> None:
    """Makes the operators known."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Takes them back, last first."""
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
