# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.deform_points, isochor.bake_points and isochor.restore_points."""

import bpy

from ..core.problem import Problem, in_edit_mode
from ..core.settings import METHODS, Parts, Settings
from ..core.words import Sentence, named
from ..tool import adding, control_points, deforming_points, point_rest, words
from ..tool.deforming_points import Deformer
from .adding import BASIS_ITEMS
from .choosing import active_object
from .frames import FrameRange
from .stepping import Stepping

SELECT = "Select a surface, curve or lattice, and last the lattice that is to deform it"
OUTSIDE_ITEMS = (
    ("KEEP", "Keep", "Points outside the lattice stay where they are"),
    ("EXTEND", "Extend", "Points outside the lattice move with the nearest point of it"),
)
SPACE_ITEMS = (
    ("GLOBAL", "Global", "The world's axes"),
    ("OBJECT", "Object", "The object's own axes"),
    ("LATTICE", "Lattice", "The lattice's axes"),
)
METHOD_ITEMS = tuple((name.upper(), name, "") for name in METHODS)
NO_LATTICE = Sentence("Select last the lattice that is to deform the others, or name it under Lattice.")


class Deforming:
    """For operators that deform control points: which lattice deforms, and how."""

    lattice: bpy.props.StringProperty(
        name="Lattice",
        description="The lattice object that deforms; empty for the active one",
        search=lambda _self, context, typed: [
            obj.name for obj in context.scene.objects if obj.type == "LATTICE" and typed.lower() in obj.name.lower()
        ],
        options={"SKIP_SAVE"},
    )
    basis: bpy.props.EnumProperty(name="Basis", description="How control points blend", items=BASIS_ITEMS)
    outside: bpy.props.EnumProperty(
        name="Outside", description="What becomes of points outside the lattice", items=OUTSIDE_ITEMS
    )
    strength: bpy.props.FloatProperty(
        name="Strength", description="How much of the deformation each point takes", default=1.0, min=0.0, max=1.0
    )
    preserve: bpy.props.FloatProperty(
        name="Preserve",
        description="How much of the lost or gained volume of a closed surface is restored, by moving its points",
        default=1.0,
        min=0.0,
        max=1.0,
    )
    target: bpy.props.FloatProperty(name="Target", description="Factor on the volume to keep", default=1.0, min=0.0)
    axes: bpy.props.FloatVectorProperty(
        name="Axes",
        description="Shares of X, Y and Z in the correction; 0 leaves an axis alone",
        default=(1.0, 1.0, 1.0),
        min=0.0,
        size=3,
    )
    space: bpy.props.EnumProperty(name="Space", description="What X, Y and Z mean in Axes", items=SPACE_ITEMS)
    method: bpy.props.EnumProperty(
        name="Method", description="How the correction finds its way, as in the modifier", items=METHOD_ITEMS
    )
    close_holes: bpy.props.BoolProperty(
        name="Close Holes", description="Measure an open surface as if its holes were closed; it stays open"
    )

    def chosen(self, context: bpy.types.Context) -> tuple[list[bpy.types.Object], Deformer]:
        """What to deform, and by what. Raises Problem where that is not to be found."""
        active = active_object(context)
        lattice = context.scene.objects.get(self.lattice) if self.lattice else active
        if lattice is None or lattice.type != "LATTICE":
            raise Problem(NO_LATTICE)
        objects = [obj for obj in pointed(context) if obj != lattice]
        if not objects:
            raise Problem(SELECT + ".")
        return objects, Deformer(lattice, self._settings())

    def _settings(self) -> Settings:
        x, y, z = self.axes
        return Settings(
            strength=self.strength,
            preserve=self.preserve,
            target=self.target,
            axes=(x, y, z),
            space=self.space.title(),
            method=self.method.title(),
            basis=adding.BASIS_NAMES[self.basis],
            outside=self.outside.title(),
            parts=Parts(close_holes=self.close_holes),
        )


class ISOCHOR_OT_deform_points(Deforming, bpy.types.Operator):
    """Deform the control points of the selected surfaces, curves and lattices by the active lattice. A closed surface
    keeps its volume. The points at rest are kept: done again, it begins with those"""

    bl_idname = "isochor.deform_points"
    bl_label = "Deform Points"
    bl_options = {"REGISTER", "UNDO"}

    anew: bpy.props.BoolProperty(
        name="From Here",
        description="Deform the points as they stand, which become those at rest, instead of those at rest until now",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return polled(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            objects, deformer = self.chosen(context)
            found = deforming_points.deform_now(objects, deformer, self.anew, context)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        for obj, deformed in found:
            if deformed.trouble:
                self.report({"WARNING"}, words.reported(named(obj.name, deformed.trouble)))
            elif deformed.volume is not None:
                self.report({"INFO"}, words.reported(kept(obj.name, deformed.volume)))
        return {"FINISHED"}


class ISOCHOR_OT_bake_points(Deforming, Stepping, FrameRange, bpy.types.Operator):
    """Record the control points of the selected surfaces, curves and lattices, deformed by the active lattice, over a
    range of frames as shape keys, which play and render without this add-on. The points at rest are kept"""

    bl_idname = "isochor.bake_points"
    bl_label = "Bake Points"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return polled(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        try:
            self.take_frames(context.scene)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        self._with_progress = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            span = self.take_frames(context.scene)
            objects, deformer = self.chosen(context)
        except Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        return self.run(context, deforming_points.bake(objects, deformer, span, context))


class ISOCHOR_OT_restore_points(bpy.types.Operator):
    """Give the selected surfaces, curves and lattices their points at rest back, exactly as they were before they were
    deformed or baked"""

    bl_idname = "isochor.restore_points"
    bl_label = "Restore Points"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if any(map(point_rest.is_deformed, pointed(context))):
            return True
        cls.poll_message_set("Select a surface, curve or lattice whose points were deformed or baked")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = [obj for obj in pointed(context) if point_rest.is_deformed(obj)]
        editing = [obj.name for obj in objects if obj.mode == "EDIT"]
        if editing:
            self.report({"ERROR"}, words.reported(in_edit_mode(editing)))
            return {"CANCELLED"}
        for obj in objects:
            point_rest.remove(point_rest.restore(obj))
        return {"FINISHED"}


def pointed(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects that have control points, and the active one."""
    active = active_object(context)
    chosen = dict.fromkeys([*context.view_layer.objects.selected, *([active] if active is not None else [])])
    return [obj for obj in chosen if obj.type in control_points.KINDS]


def polled(kind: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether there is anything with control points; else says what to select, and what has none."""
    if pointed(context):
        return True
    active = active_object(context)
    if active is not None and active.type == "META":
        kind.poll_message_set("Metaballs have no points: convert them to a mesh, and use Add Volume Lattice")
    else:
        kind.poll_message_set(SELECT)
    return False


def kept(name: str, volume: float) -> Sentence:
    """What a closed surface keeps."""
    return Sentence("“{name}” keeps a volume of {volume}", name=name, volume=f"{volume:.6g}")


CLASSES = (ISOCHOR_OT_deform_points, ISOCHOR_OT_bake_points, ISOCHOR_OT_restore_points)


def register() -> None:
    """Makes the operators known."""
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    """Takes them back, last first."""
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
