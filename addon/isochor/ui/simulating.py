# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.simulate and isochor.free_simulation."""

from collections.abc import Generator, Iterator

import bpy

import isochor

from ..core import problem
from ..tool import baked, baked_lattice, simulation, words
from ..tool.frames import frame_kept
from ..tool.lattices import of_all, users_of
from .choosing import active_object, chosen_lattices, chosen_modifiers
from .simulation_settings import SimulationSettings
from .stepping import Stepping


class ISOCHOR_OT_simulate(SimulationSettings, Stepping, bpy.types.Operator):
    """Let the lattice fall, bounce and wobble as jelly over the frame range, kept as shape keys of the lattice.
    The lattice's own points and keys are kept and come back with Free Simulation"""

    _broken_off = "Broken off: nothing was kept"
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
        self._with_progress = not bpy.app.background
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        lattices = of_all(chosen_modifiers(context))
        self.fill_in(context, lattices)
        try:
            refuse(lattices, self.frame_start, self.frame_end)
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        return self.run(context, self._simulated(context, lattices))

    def how_far(self, step: float) -> tuple[float, str]:
        """The share that is done."""
        return step, "Simulating. Esc: cancel, nothing is changed"

    def _simulated(self, context: bpy.types.Context, lattices: list[bpy.types.Object]) -> Generator[float]:
        """Simulates all, then bakes all: a cancelled or failed one changes nothing."""
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
            except isochor.Error as error:
                raise problem.Problem(problem.sentence(error)) from error
            finally:
                for lattice, before in freed.items():
                    baked_lattice.put_back(lattice, before)

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
