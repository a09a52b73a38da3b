# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.simulate and isochor.free_simulation."""

from collections.abc import Generator, Iterator
from time import perf_counter

import bpy

import isochor

from ..core import problem
from ..tool import baked, baked_lattice, simulation, words
from ..tool.frames import frame_kept
from ..tool.lattices import of_all, users_of
from .choosing import active_object, chosen_lattices, chosen_modifiers
from .simulation_settings import SimulationSettings

Work = Generator[float, None, set[str]]
TURN = 0.05
"""Seconds of work between two looks at the keyboard."""


class ISOCHOR_OT_simulate(SimulationSettings, bpy.types.Operator):
    """Let the lattice fall, bounce and wobble as jelly over the frame range, kept as shape keys of the lattice.
    The lattice's own points and keys are kept and come back with Free Simulation"""

    bl_idname = "isochor.simulate"
    bl_label = "Simulate Jelly"
    bl_options = {"REGISTER", "UNDO"}

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
        context.workspace.status_text_set(words.shown("Simulating. Esc: cancel, nothing is changed"))
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
        lattices = of_all(chosen_modifiers(context))
        self.fill_in(context, lattices)
        try:
            refuse(lattices, self.frame_start, self.frame_end)
            return self._simulated(context, lattices)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return None

    def _simulated(self, context: bpy.types.Context, lattices: list[bpy.types.Object]) -> Work:
        """Simulates all, then bakes all: a cancelled or failed one changes nothing. Ends with the outcome."""
        with frame_kept(context.scene):
            freed = {lattice: baked_lattice.free(lattice) for lattice in lattices if baked_lattice.is_baked(lattice)}
            found = {lattice: simulation.Shapes(0, []) for lattice in lattices}
            try:
                for number, lattice in enumerate(lattices):
                    for share in self._one(context, lattice, found[lattice]):
                        yield (number + share) / len(lattices)
                for lattice in lattices:
                    if lattice in freed:
                        baked_lattice.remove(freed.pop(lattice))
                    baked_lattice.bake(lattice, found[lattice].first, found[lattice].points, self.as_kept())
            except (problem.Problem, isochor.Error) as trouble:
                text = trouble.sentence if isinstance(trouble, problem.Problem) else problem.sentence(trouble)
                self.report({"ERROR"}, words.reported(text))
                return {"CANCELLED"}
            finally:
                for lattice, before in freed.items():
                    baked_lattice.put_back(lattice, before)
        return {"FINISHED"}

    def _one(self, context: bpy.types.Context, lattice: bpy.types.Object, shapes: simulation.Shapes) -> Iterator[float]:
        context.scene.frame_set(self.frame_start)
        users = simulation.users_in(context, lattice)
        span = simulation.Range(self.frame_start, self.frame_end, self.use_motion, self.pinned)
        return simulation.simulate(context, lattice, users, span, self.for_core(context), shapes)


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
            self.report({"ERROR"}, words.reported(problem.foreign(", ".join(foreign))))
            return {"CANCELLED"}
        for lattice in lattices:
            baked_lattice.remove(baked_lattice.free(lattice))
        return {"FINISHED"}


def simulated_lattices(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The lattices meant that show a simulation."""
    return [lattice for lattice in chosen_lattices(context) if baked_lattice.is_baked(lattice)]


def refuse(lattices: list[bpy.types.Object], start: int, end: int) -> None:
    """Raises the Problem of what cannot be simulated at all."""
    if not lattices:
        raise problem.Problem(problem.NO_LATTICE)
    foreign = [lattice.name for lattice in lattices if not lattice.is_editable]
    if foreign:
        raise problem.Problem(problem.foreign(", ".join(foreign)))
    editing = [lattice.name for lattice in lattices if lattice.mode != "OBJECT"]
    if editing:
        raise problem.Problem(problem.in_edit_mode(editing))
    for lattice in lattices:
        playing = [obj.name for obj, _modifier in users_of(lattice) if baked.is_playing(obj)]
        if playing:
            raise problem.Problem(problem.plays_bake(playing[0]))
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
