# SPDX-License-Identifier: GPL-3.0-or-later
"""What isochor.simulate asks for."""

from typing import Any

import bpy

from ..core import problem
from ..core.simulation import Options
from ..tool import baked_lattice, simulation
from ..tool.lattices import of_all
from .choosing import chosen_modifiers

GROUNDS = ("MESH", "EMPTY", "CURVE", "SURFACE", "FONT", "META")


def object_names(_owner: object, context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the scene's objects that can be a ground and hold what was typed."""
    return [obj.name for obj in context.scene.objects if obj.type in GROUNDS and typed.lower() in obj.name.lower()]


def group_names(_owner: object, context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the vertex groups of the lattices meant."""
    lattices = of_all(chosen_modifiers(context))
    return [
        group.name for lattice in lattices for group in lattice.vertex_groups if typed.lower() in group.name.lower()
    ]


class SimulationSettings:
    """The operator's properties. None is remembered from the call before: what a lattice was simulated with is kept
    with it, and stands in for what is left out the next time."""

    frame_start: bpy.props.IntProperty(
        options={"SKIP_SAVE"},
        name="Start",
        description="Frame in which the lattice is let go. Unset: the scene's first",
        default=1,
    )
    frame_end: bpy.props.IntProperty(
        options={"SKIP_SAVE"}, name="End", description="Last frame. Unset: the scene's last", default=250
    )
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
        description="How fast the wobbling dies away: 0 never, 1 without one overshoot. A fall is not slowed",
        default=0.1,
        min=0.0,
        max=2.0,
        soft_max=1.0,
    )
    friction: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Friction",
        description="How much the ground holds: 0 is ice, 1 rubber",
        default=0.5,
        min=0.0,
        soft_max=1.0,
    )
    use_scene_gravity: bpy.props.BoolProperty(
        options={"SKIP_SAVE"},
        name="Scene Gravity",
        description="Take the gravity of the scene's settings",
        default=True,
    )
    gravity: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"},
        name="Gravity",
        description="Acceleration, where the scene's is not taken",
        default=(0.0, 0.0, -9.81),
        subtype="ACCELERATION",
    )
    use_ground: bpy.props.BoolProperty(
        options={"SKIP_SAVE"}, name="Ground", description="Whether there is a ground to land on", default=True
    )
    ground_object: bpy.props.StringProperty(
        options={"SKIP_SAVE"},
        name="Ground Object",
        description="Object whose top, along its own Z axis, is the ground, as it stands in the first frame; it may be"
        " tilted. Empty: level ground at the height below",
        search=object_names,
    )
    ground_height: bpy.props.FloatProperty(
        options={"SKIP_SAVE"},
        name="Height",
        description="Where level ground is, if no object is named",
        subtype="DISTANCE",
        unit="LENGTH",
    )
    use_motion: bpy.props.BoolProperty(
        options={"SKIP_SAVE"},
        name="Keep Motion",
        description="Start with the velocity that the lattice has in the animation, from the frame before",
        default=True,
    )
    velocity: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"}, name="Throw", description="Velocity in the world, added to that", subtype="VELOCITY"
    )
    spin: bpy.props.FloatVectorProperty(
        options={"SKIP_SAVE"},
        name="Spin",
        description="Angle turned each second about the world's axes, added to that",
        subtype="EULER",
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

    def fill_in(self: Any, context: bpy.types.Context, lattices: list[bpy.types.Object]) -> None:
        """What the caller left out is as in the simulation that is there, else the scene's range and the defaults."""
        scene = context.scene
        known = {"frame_start": scene.frame_start, "frame_end": scene.frame_end}
        for lattice in lattices[:1]:
            known.update(baked_lattice.settings_of(lattice))
        for name, value in known.items():
            if not self.properties.is_property_set(name):
                setattr(self, name, value)

    def as_kept(self) -> dict[str, object]:
        """All of them, by name."""
        return {name: plain(getattr(self, name)) for name in SimulationSettings.__annotations__}

    def for_core(self, context: bpy.types.Context) -> Options:
        """What the core needs of them; raises Problem where the ground is missing."""
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

    def draw(self: Any, _context: bpy.types.Context) -> None:
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


def plain(value: Any) -> object:
    """A property's value as JSON has it."""
    return value if isinstance(value, bool | int | float | str) else list(value)
