# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.add_pin, isochor.bind_pins and isochor.remove_pins."""

import bpy
import numpy as np

from ..core import pin_problem, problem
from ..core.words import named
from ..tool import pin_collection, pin_selection, pinning, pins, state, words
from ..tool.lattices import Pair
from . import picking
from .choosing import active_object, chosen_modifiers

NONE_CHOSEN = "Select a mesh with a Volume Lattice, its lattice, or one of its pins"
WHERE_ITEMS = (
    ("SELECTION", "Selection", "Every selected vertex, or with faces selected the middle of each"),
    ("POINT", "Point", "The point of the surface nearest to Point"),
)


class ISOCHOR_OT_add_pin(bpy.types.Operator):
    """Make empties that hold points of the surface: where an empty goes, its point follows, and the volume stays. In
    Edit Mode one for each selected vertex, or for each face where faces are selected; else click on the surface"""

    bl_idname = "isochor.add_pin"
    bl_label = "Add Pin"
    bl_options = {"REGISTER", "UNDO"}

    where: bpy.props.EnumProperty(
        name="Where", description="Which points are pinned", items=WHERE_ITEMS, options={"SKIP_SAVE"}
    )
    point: bpy.props.FloatVectorProperty(
        name="Point",
        description="A place in the world, on the surface or near it",
        subtype="XYZ",
        options={"SKIP_SAVE"},
    )
    snap: bpy.props.BoolProperty(
        name="Snap to Vertex", description="Pin the nearest vertex instead of a point of a face"
    )
    follow: bpy.props.BoolProperty(
        name="Follow Object",
        description="Make the empties children of the object, so that they move along with it",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return polled(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """In Edit Mode takes the selection; else waits for a click on the surface."""
        editing = any(obj.mode == "EDIT" for obj, _modifier in pinned_modifiers(context))
        told = self.properties.is_property_set("where") or self.properties.is_property_set("point")
        if editing or told or context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        picking.start(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Waits for a click; the view can be turned meanwhile."""
        if event.type in picking.BREAKS_OFF:
            picking.end(context)
            return {"CANCELLED"}
        if picking.navigates(event):
            return {"PASS_THROUGH"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"RUNNING_MODAL"}
        objects = [obj for obj, _modifier in pinned_modifiers(context)]
        found = picking.under_cursor(context, event, objects)
        if found is None:
            self.report({"INFO"}, "Click on the surface of the mesh, or press Esc")
            return {"RUNNING_MODAL"}
        picking.end(context)
        self.where, self.point = "POINT", found
        return self.execute(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender breaks it off, as where the window closes."""
        picking.end(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            made = self._add(context)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        select_alone(made, context)
        return {"FINISHED"}

    def _add(self, context: bpy.types.Context) -> list[bpy.types.Object]:
        pairs = pinned_modifiers(context)
        for pair in pairs:
            pin_collection.refuse(*pair)
        leave_edit_mode(pairs, context)
        found = self._points(pairs, context)
        made = [empty for pair, points in found for empty in pinning.add(pair, points, self.follow, context)]
        context.view_layer.update()
        warn(self, [pair for pair, _points in found])
        return made

    def _points(self, pairs: list[Pair], context: bpy.types.Context) -> list[tuple[Pair, list[pinning.Point]]]:
        """What to pin of each modifier; raises ``Problem`` where there is nothing."""
        depsgraph = context.evaluated_depsgraph_get()
        if self.where == "POINT":
            return [self._nearest(pairs, depsgraph)]
        faces = tuple(context.tool_settings.mesh_select_mode) == (False, False, True)
        found = []
        for pair in pairs:
            points = pin_selection.points(pair, faces, depsgraph)
            refuse_more_than_the_lattice_has(pair, points)
            found += [(pair, points)] if points else []
        if not found:
            raise problem.Problem(pin_problem.NOTHING_SELECTED)
        return found

    def _nearest(self, pairs: list[Pair], depsgraph: bpy.types.Depsgraph) -> tuple[Pair, list[pinning.Point]]:
        """The point of all the surfaces that is nearest to the one given."""
        world, found = np.array(self.point, np.float64), []
        for pair in pairs:
            shape = pinning.shape_of(*pair, depsgraph)
            point = shape.nearest(world)
            distance = float(np.linalg.norm(point.world - world))
            found.append((distance, pair, shape.snapped(point) if self.snap else point))
        _distance, pair, point = min(found, key=lambda one: one[0])
        return pair, [point]


class ISOCHOR_OT_bind_pins(bpy.types.Operator):
    """Have the selected empties, or whatever objects, hold the points of the surface that are nearest to them, which
    from now on go along with them. With no such object selected: all pins that the mesh has lost, because it has other
    vertices now or they were never bound"""

    bl_idname = "isochor.bind_pins"
    bl_label = "Bind Pins"
    bl_options = {"REGISTER", "UNDO"}

    anew: bpy.props.BoolProperty(
        name="Where They Stand",
        description="Bind pins that the mesh has lost to the surface where they stand now, instead of to the place that"
        " they had on it",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return polled(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = pinned_modifiers(context)
        try:
            for pair in pairs:
                pin_collection.refuse(*pair)
            leave_edit_mode(pairs, context)
            chosen = selected_holders(pairs, context)
            bound = [(pair, chosen or pinning.in_need(pair)) for pair in pairs]
            if not any(holders for _pair, holders in bound):
                raise problem.Problem(pin_problem.NOTHING_TO_BIND)
            for pair, holders in bound:
                if holders:
                    pinning.bind(pair, holders, self.anew, context)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        context.view_layer.update()
        warn(self, pairs)
        return {"FINISHED"}


class ISOCHOR_OT_remove_pins(bpy.types.Operator):
    """Take the selected pins away, or with none selected all of them: empties that Add Pin made are deleted, other
    objects leave the collection and stay in the scene"""

    bl_idname = "isochor.remove_pins"
    bl_label = "Remove Pins"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return polled(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = pinned_modifiers(context)
        chosen = {obj.session_uid for obj in selected_holders(pairs, context)}
        try:
            for pair in pairs:
                pin_collection.refuse(*pair)
            removed = pin_collection.empty(pairs, chosen, context.scene)
            if not removed:
                raise problem.Problem(pin_problem.NO_PINS)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        if context.view_layer.objects.active is None and pairs[0][0].name in context.view_layer.objects:
            context.view_layer.objects.active = pairs[0][0]
        return {"FINISHED"}


def polled(kind: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether there is a modifier to work on; else says what to select."""
    if pinned_modifiers(context):
        return True
    kind.poll_message_set(NONE_CHOSEN)
    return False


def pinned_modifiers(context: bpy.types.Context) -> list[Pair]:
    """The chosen modifiers; where there are none, those that the active or selected objects are pins of."""
    found = chosen_modifiers(context)
    if found:
        return found
    active = active_object(context)
    chosen = list(dict.fromkeys([active, *context.view_layer.objects.selected]))
    users = [pair for obj in chosen if obj is not None for pair in pin_collection.users(obj)]
    return list({(obj.session_uid, modifier.persistent_uid): (obj, modifier) for obj, modifier in users}.values())


def selected_holders(pairs: list[Pair], context: bpy.types.Context) -> list[bpy.types.Object]:
    """Selected objects that are, or can become, pins of these modifiers: neither their meshes nor lattices."""
    meshes = [obj for obj, _modifier in pairs]
    held = [obj for _obj, modifier in pairs for obj in pins.objects(modifier)]
    selected = [obj for obj in context.view_layer.objects.selected if obj not in meshes]
    return [obj for obj in selected if obj in held or obj.type != "LATTICE"]


def refuse_more_than_the_lattice_has(pair: Pair, points: list[pinning.Point]) -> None:
    """Raises ``Problem`` where there are more points to pin than points of the lattice that could move for them."""
    memory = state.recall(*pair)
    grid = None if memory is None else memory.report.grid
    if grid is not None and len(points) > int(np.prod(grid.shape)):
        raise problem.Problem(pin_problem.too_many(pair[0].name, len(points), int(np.prod(grid.shape))))


def leave_edit_mode(pairs: list[Pair], context: bpy.types.Context) -> None:
    """Into Object Mode where a mesh is being edited: there its shape is computed, and its pins can be moved."""
    if any(obj.mode == "EDIT" for obj, _modifier in pairs):
        bpy.ops.object.mode_set(mode="OBJECT")
        context.view_layer.update()


def select_alone(made: list[bpy.types.Object], context: bpy.types.Context) -> None:
    """Selects the new empties, so that they can be moved at once; not where their collection is excluded."""
    there = [empty for empty in made if empty.name in context.view_layer.objects]
    if not there:
        return
    for obj in context.view_layer.objects.selected:
        obj.select_set(False)
    for empty in there:
        empty.select_set(True)
    context.view_layer.objects.active = there[-1]


def warn(operator: bpy.types.Operator, pairs: list[Pair]) -> None:
    """Reports what is wrong with the modifiers now."""
    for obj, modifier in pairs:
        memory = state.recall(obj, modifier)
        for text in () if memory is None else memory.report.problems:
            operator.report({"WARNING"}, words.reported(named(obj.name, text)))


CLASSES = (ISOCHOR_OT_add_pin, ISOCHOR_OT_bind_pins, ISOCHOR_OT_remove_pins)


def register() -> None:
    """Makes the operators known."""
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    """Takes them back, last first."""
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
