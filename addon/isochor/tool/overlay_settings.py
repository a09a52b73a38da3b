# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows: kept in the workspace, as Blender keeps its own overlays with the editor. So it is saved with
the file, undo leaves it alone, and a maximised area keeps it."""

import bpy

from ..core.isolines import Wanted

PROPERTY = "isochor_overlay"
"""Of bpy.types.WorkSpace."""


class IsochorOverlay(bpy.types.PropertyGroup):
    """What the overlay shows of each Volume Lattice"""

    show: bpy.props.BoolProperty(
        name="Volume Lattice", description="Draw what the volume correction makes of the lattice", default=False
    )
    only_selected: bpy.props.BoolProperty(
        name="Selected Only",
        description="Draw it for objects that are active or selected, or whose lattice is, instead of all in view",
        default=False,
    )
    show_lattice: bpy.props.BoolProperty(
        name="Corrected Lattice",
        description="Lines of the lattice as it shapes the mesh, after the correction",
        default=True,
    )
    show_points: bpy.props.BoolProperty(
        name="Control Points",
        description="Corrected control points, coloured by how far the correction moved them, each with a line from"
        " where it was set",
        default=True,
    )
    show_isolines: bpy.props.BoolProperty(
        name="Deformed Space",
        description="Lines of the space inside the lattice, straight and evenly spaced before it was deformed",
        default=False,
    )
    show_folds: bpy.props.BoolProperty(
        name="Folds",
        description="Mark where the lattice folds over itself (red), and where that cannot be told (orange), in front"
        " of everything; not while the animation plays",
        default=False,
    )
    show_legend: bpy.props.BoolProperty(
        name="Legend", description="Say in the view what the colours of the control points mean", default=True
    )
    divisions: bpy.props.IntProperty(
        name="Divisions",
        description="Parts that the lines divide each side into",
        default=8,
        min=1,
        max=64,
        soft_max=24,
    )
    samples: bpy.props.IntProperty(
        name="Smoothness",
        description="Straight pieces of each line, at least",
        default=32,
        min=1,
        max=512,
        soft_max=128,
    )
    inside: bpy.props.BoolProperty(
        name="Inside", description="Draw the lines inside the box too, not only those on its faces", default=False
    )
    in_front: bpy.props.BoolProperty(
        name="In Front",
        description="Draw over everything; otherwise what stands before the lines hides them",
        default=False,
    )
    colour_range: bpy.props.FloatProperty(
        name="Colour Range",
        description="Displacement that has the last colour; 0 takes the largest one in view, frame by frame",
        default=0.0,
        min=0.0,
        unit="LENGTH",
    )
    lattice_colour: bpy.props.FloatVectorProperty(
        name="Lattice Colour",
        description="Colour of the corrected lattice",
        subtype="COLOR_GAMMA",
        size=4,
        default=(0.25, 0.78, 0.86, 1.0),
        min=0.0,
        max=1.0,
    )
    space_colour: bpy.props.FloatVectorProperty(
        name="Space Colour",
        description="Colour of the lines of the deformed space",
        subtype="COLOR_GAMMA",
        size=4,
        default=(0.95, 0.95, 0.95, 0.55),
        min=0.0,
        max=1.0,
    )
    line_width: bpy.props.FloatProperty(
        name="Line Width", description="Width of the lattice's lines, in pixels", default=2.0, min=0.5, max=10.0
    )
    point_size: bpy.props.FloatProperty(
        name="Point Size", description="Diameter of the control points, in pixels", default=9.0, min=1.0, max=40.0
    )

    def wanted(self) -> Wanted | None:
        """How the iso-parameter lines are laid; None where they are not shown."""
        return Wanted(self.divisions, self.samples, self.inside) if self.show_isolines else None


def of(workspace: bpy.types.WorkSpace) -> IsochorOverlay:
    """A workspace's settings."""
    return getattr(workspace, PROPERTY)


def register() -> None:
    """Gives every workspace the settings."""
    bpy.utils.register_class(IsochorOverlay)
    setattr(bpy.types.WorkSpace, PROPERTY, bpy.props.PointerProperty(type=IsochorOverlay))


def unregister() -> None:
    """Takes them away."""
    delattr(bpy.types.WorkSpace, PROPERTY)
    bpy.utils.unregister_class(IsochorOverlay)
