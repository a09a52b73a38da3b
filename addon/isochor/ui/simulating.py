# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.simulate and isochor.free_simulation."""

from collections.abc import Generator, Iterator
from time import perf_counter

import bpy

import isochor

from ..core import problem
from ..core.simulation import Options
from ..tool import baked_lattice, simulation
from .choosing import active_object, chosen_modifiers

Work = Generator[float, None, set[str]]
TURN = 0.05
"""Seconds of work between two looks at the keyboard."""


def object_names(_owner: object, context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the scene's objects that can be a ground and hold what was typed."""
    return [obj.name for obj in context.scene.objects if obj.type in GROUNDS and typed.lower() in obj.name.lower()]


def group_names(_owner: object, context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the vertex groups of the lattices meant."""
    lattices = simulation.lattices_of(chosen_modifiers(context))
    return [group.name for lattice in lattices for group in lattice.vertex_groups if typed.lower() in group.name.lower()]


GROUNDS = ("MESH", "EMPTY", "CURVE", "SURFACE", "FONT", "META")


class ISOCHOR_OT_simulate(bpy.types.Operator):
    """Let the lattice fall, bounce and wobble as jelly over the frame range, and keep the result as shape keys of the lattice.
    The lattice's own points and keys are kept and come back with Free Simulation"""

    bl_idname = "isochor.simulate"
    bl_label = "Simulate Jelly"
    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(
        options={"SKIP_SAVE"},
        name="Start", description="Frame in which the lattice is let go. Unset: the scene's first", default=1
    )
    frame_end: bpy.props.IntProperty(options={"SKIP_SAVE"}, name="End", description="Last frame. Unset: the scene's last", default=250)
    stiffness: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Stiffness",
        description="How often a second the free lattice would wobble along its longest side: low is soft jelly, high"
        " hard rubber. It needs no size: a small and a large ball of the same stiffness wobble alike",
        default=2.2,
        min=0.1,
        max=50.0,
        soft_max=10.0,
    )
    damping: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Damping",
        description="How fast the wobbling dies away: 0 never, 1 without one overshoot. Falling and turning are not slowed",
        default=0.06,
        min=0.0,
        max=2.0,
        soft_max=1.0,
    )
    friction: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Friction", description="How much the ground holds: 0 is ice, 1 rubber", default=0.5, min=0.0, soft_max=1.0
    )
    use_scene_gravity: bpy.props.BoolProperty(
        options={"SKIP_SAVE"},
        name="Scene Gravity", description="Take the gravity of the scene's settings", default=True
    )
    gravity: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"},
        name="Gravity",
        description="Acceleration, where the scene's is not taken",
        default=(0.0, 0.0, -9.81),
        subtype="ACCELERATION",
    )
    use_ground: bpy.props.BoolProperty(options={"SKIP_SAVE"}, name="Ground", description="Whether there is a ground to land on", default=True)
    ground_object: bpy.props.StringProperty(
        options={"SKIP_SAVE"},
        name="Ground Object",
        description="Object whose top, along its own Z axis, is the ground, as it stands in the first frame; it may be"
        " tilted. Empty: level ground at the height below",
        search=object_names,
    )
    ground_height: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Height", description="Where level ground is, if no object is named", subtype="DISTANCE", unit="LENGTH"
    )
    use_motion: bpy.props.BoolProperty(
        options={"SKIP_SAVE"},
        name="Keep Motion",
        description="Start with the velocity that the lattice has in the animation, from the frame before",
        default=True,
    )
    velocity: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"},
        name="Throw", description="Velocity in the world, added to that", subtype="VELOCITY"
    )
    spin: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"},
        name="Spin", description="Angle turned each second about the world's axes, added to that", subtype="EULER"
    )
    pinned: bpy.props.StringProperty(
        options={"SKIP_SAVE"},
        name="Pinned",
        description="Vertex group of the lattice: points with a weight of one half and more follow the animation",
        search=group_names,
    )
    substeps: bpy.props.IntProperty(
        options={"SKIP_SAVE"},
        name="Substeps",
        description="Steps each frame at least; a stiff or fine lattice takes more by itself",
        default=8,
        min=1,
        max=1000,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = active_object(context)
        if active is not None and active.mode != "OBJECT":
            cls.poll_message_set("Leave Edit Mode first: a simulation needs Object Mode")
        elif not chosen_modifiers(context):
            cls.poll_message_set("Select a mesh with a Volume Lattice, or its lattice")
        else:
            return True
        return False

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Simulates beside the interface, so that it shows how far it is and Esc ends it."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        work = self._prepared(context)
        if work is None:
            return {"CANCELLED"}
        self._work, self._manager = work, context.window_manager
        self._manager.progress_begin(0.0, 1.0)
        self._timer = self._manager.event_timer_add(0.01, window=context.window)
        context.workspace.status_text_set("Simulating: Esc to cancel")
        self._manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """A little at every tick of the clock."""
        if event.type == "ESC":
            self._work.close()
            return self._ended(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        until = perf_counter() + TURN
        try:
            while perf_counter() < until:
                self._manager.progress_update(next(self._work))
        except StopIteration as done:
            return self._ended(context, done.value)
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender is closing or loading another file."""
        self._work.close()
        self._ended(context, {"CANCELLED"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        work = self._prepared(context)
        if work is None:
            return {"CANCELLED"}
        while True:
            try:
                next(work)
            except StopIteration as done:
                return done.value

    def _ended(self, context: bpy.types.Context, outcome: set[str]) -> set[str]:
        self._manager.event_timer_remove(self._timer)
        self._manager.progress_end()
        context.workspace.status_text_set(None)
        return outcome

    def _prepared(self, context: bpy.types.Context) -> Work | None:
        """The work to do, or None where something is wrong, which then has been said."""
        lattices = simulation.lattices_of(chosen_modifiers(context))
        self._fill_in(context, lattices)
        try:
            refuse(lattices, self.frame_start, self.frame_end)
            return self._simulated(context, lattices)
        except problem.Problem as trouble:
            self.report({"ERROR"}, str(trouble))
            return None

    def _fill_in(self, context: bpy.types.Context, lattices: list[bpy.types.Object]) -> None:
        """What the caller left out is as in the simulation that is there, else the scene's range and the defaults."""
        scene = context.scene
        known = {"frame_start": scene.frame_start, "frame_end": scene.frame_end}
        for lattice in lattices[:1]:
            known.update(baked_lattice.settings_of(lattice))
        for name, value in known.items():
            if not self.properties.is_property_set(name):
                setattr(self, name, value)

    def _settings(self) -> dict[str, object]:
        return {name: plain(getattr(self, name)) for name in type(self).__annotations__}

    def _simulated(self, context: bpy.types.Context, lattices: list[bpy.types.Object]) -> Work:
        """Simulates all, then bakes all: a cancelled or failed one changes nothing. Ends with the operator's outcome."""
        frame, subframe = context.scene.frame_current, context.scene.frame_subframe
        freed = {lattice: baked_lattice.free(lattice) for lattice in lattices if baked_lattice.is_baked(lattice)}
        found = {lattice: simulation.Shapes(0, []) for lattice in lattices}
        try:
            for number, lattice in enumerate(lattices):
                for share in self._one(context, lattice, found[lattice]):
                    yield (number + share) / len(lattices)
            for lattice in lattices:
                if lattice in freed:
                    baked_lattice.remove(freed.pop(lattice))
                baked_lattice.bake(lattice, found[lattice].first, found[lattice].points, self._settings())
        except (problem.Problem, isochor.Error) as trouble:
            text = str(trouble) if isinstance(trouble, problem.Problem) else problem.sentence(trouble)
            self.report({"ERROR"}, text)
            return {"CANCELLED"}
        finally:
            for lattice, baked in freed.items():
                baked_lattice.put_back(lattice, baked)
            context.scene.frame_set(frame, subframe=subframe)
        return {"FINISHED"}

    def _one(
        self, context: bpy.types.Context, lattice: bpy.types.Object, shapes: simulation.Shapes
    ) -> Iterator[float]:
        context.scene.frame_set(self.frame_start)
        users = simulation.users_in(context, lattice)
        span = simulation.Range(self.frame_start, self.frame_end, self.use_motion, self.pinned)
        return simulation.simulate(context, lattice, users, span, self._options(context), shapes)

    def _options(self, context: bpy.types.Context) -> Options:
        scene = context.scene
        gravity = tuple(scene.gravity if scene.use_gravity else (0.0, 0.0, 0.0))
        return Options(
            frequency=self.stiffness,
            damping=self.damping,
            friction=self.friction,
            gravity=gravity if self.use_scene_gravity else tuple(self.gravity),
            ground=self._ground(context) if self.use_ground else None,
            velocity=tuple(self.velocity),
            spin=tuple(self.spin),
            substeps=self.substeps,
        )

    def _ground(self, context: bpy.types.Context) -> simulation.Plane:
        if not self.ground_object:
            return simulation.level_ground(self.ground_height)
        ground = context.scene.objects.get(self.ground_object)
        if ground is None:
            raise problem.Problem(problem.no_ground(self.ground_object))
        return simulation.ground_plane(ground)

    def draw(self, _context: bpy.types.Context) -> None:
        """The redo panel."""
        layout = self.layout
        layout.use_property_split = True
        for names in (("frame_start", "frame_end"), ("stiffness", "damping", "substeps"), ("use_scene_gravity",)):
            column = layout.column(align=True)
            for name in names:
                column.prop(self, name)
        if not self.use_scene_gravity:
            layout.prop(self, "gravity")
        layout.prop(self, "use_ground")
        column = layout.column(align=True)
        column.active = self.use_ground
        column.prop(self, "ground_object", icon="OBJECT_DATA")
        if not self.ground_object:
            column.prop(self, "ground_height")
        column.prop(self, "friction")
        for name in ("use_motion", "velocity", "spin"):
            layout.prop(self, name)
        layout.prop(self, "pinned", icon="GROUP_VERTEX")


class ISOCHOR_OT_free_simulation(bpy.types.Operator):
    """Take the simulation away and give the lattice its own points, shape keys and modifiers back"""

    bl_idname = "isochor.free_simulation"
    bl_label = "Free Simulation"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = active_object(context)
        if active is not None and active.mode != "OBJECT":
            cls.poll_message_set("Leave Edit Mode first: freeing a simulation needs Object Mode")
        elif not simulated_lattices(context):
            cls.poll_message_set("Nothing that is selected was simulated")
        else:
            return True
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        lattices = simulated_lattices(context)
        foreign = [lattice.name for lattice in lattices if not lattice.is_editable]
        if foreign:
            self.report({"ERROR"}, problem.from_elsewhere(foreign))
            return {"CANCELLED"}
        for lattice in lattices:
            baked_lattice.remove(baked_lattice.free(lattice))
        return {"FINISHED"}


def simulated_lattices(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The lattices meant that show a simulation."""
    return [lattice for lattice in simulation.lattices_of(chosen_modifiers(context)) if baked_lattice.is_baked(lattice)]


def plain(value: object) -> object:
    """A property's value as JSON has it."""
    return value if isinstance(value, bool | int | float | str) else list(value)


def refuse(lattices: list[bpy.types.Object], start: int, end: int) -> None:
    """Raises the Problem of what cannot be simulated at all."""
    if not lattices:
        raise problem.Problem(problem.NO_LATTICE)
    foreign = [lattice.name for lattice in lattices if not lattice.is_editable]
    if foreign:
        raise problem.Problem(problem.from_elsewhere(foreign))
    editing = [lattice.name for lattice in lattices if lattice.mode != "OBJECT"]
    if editing:
        raise problem.Problem(problem.in_edit_mode(editing))
    if end <= start:
        raise problem.Problem(problem.no_frames(start, end))


CLASSES = (ISOCHOR_OT_simulate, ISOCHOR_OT_free_simulation)


def register() -> None:
    """Makes the operators known."""
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    """Takes them back."""
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
