# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.set_rest and isochor.clear_rest."""

import bpy

from ..core import problem
from ..core.words import Sentence, named
from ..tool import binding, bound, results, state, words
from .choosing import chosen_modifiers

NONE_CHOSEN = "Select a mesh with a Volume Lattice, or its lattice"


class ISOCHOR_OT_set_rest(bpy.types.Operator):
    """Bind the mesh with the lattice as it stands: its present shape and place move nothing, and from now on both are
    measured from here. A lattice can so be shaped first, and moving it moves the mesh. Measures the volume to keep
    anew"""

    bl_idname = "isochor.set_rest"
    bl_label = "Set Rest"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set(NONE_CHOSEN)
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = chosen_modifiers(context)
        if refuse_foreign(self, pairs):
            return {"CANCELLED"}
        depsgraph = context.evaluated_depsgraph_get()
        shapes = []
        for obj, modifier in pairs:
            try:
                shapes.append(binding.shape_now(obj, modifier, depsgraph))
            except problem.Problem as trouble:
                self.report({"ERROR"}, words.reported(named(obj.name, trouble.sentence)))
                return {"CANCELLED"}
        binding.bind(pairs, shapes, context.view_layer)
        for obj, modifier in pairs:
            for text in warnings(obj, modifier):
                self.report({"WARNING"}, words.reported(named(obj.name, text)))
        return {"FINISHED"}


class ISOCHOR_OT_clear_rest(bpy.types.Operator):
    """Unbind the mesh: vertices are embedded by where the lattice stands now, so moving an undeformed lattice deforms
    nothing. The volume to keep stays the one last measured"""

    bl_idname = "isochor.clear_rest"
    bl_label = "Clear Rest"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        pairs = chosen_modifiers(context)
        if any(map(is_bound, pairs)):
            return True
        cls.poll_message_set("None of the selected has its rest set" if pairs else NONE_CHOSEN)
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = [pair for pair in chosen_modifiers(context) if is_bound(pair)]
        if refuse_foreign(self, pairs):
            return {"CANCELLED"}
        binding.release(pairs, context.view_layer)
        return {"FINISHED"}


def is_bound(pair: binding.Pair) -> bool:
    """Whether the modifier's rest was set."""
    return bound.bound_with(results.of(pair[1], "VIEWPORT")) is not None


def refuse_foreign(operator: bpy.types.Operator, pairs: list[binding.Pair]) -> bool:
    """Whether there are objects that cannot be changed; then says which."""
    foreign = [obj.name for obj, _modifier in pairs if not obj.is_editable]
    if foreign:
        operator.report({"ERROR"}, words.reported(problem.foreign(", ".join(foreign))))
    return bool(foreign)


def warnings(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> list[str]:
    """What the animator should know of a modifier just bound."""
    memory = state.recall(obj, modifier)
    if memory is None:
        return []
    outside, asked = memory.report.vertices_outside, memory.asked
    if not outside or asked is None:
        return list(memory.report.problems)
    return [*memory.report.problems, not_inside(outside, len(asked.positions))]


def not_inside(outside: int, count: int) -> str:
    """Some of the vertices are outside the lattice."""
    return Sentence(
        "{outside} of {count} vertices are not inside the lattice: the input Outside says what becomes of them",
        outside=outside,
        count=count,
    )


CLASSES = (ISOCHOR_OT_set_rest, ISOCHOR_OT_clear_rest)


def register() -> None:
    """Makes the operators known."""
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    """Takes them back, last first."""
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
