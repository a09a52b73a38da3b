# SPDX-License-Identifier: GPL-3.0-or-later
"""What the animator set on one Volume Lattice modifier, as evaluated for one frame."""

from dataclasses import dataclass

REFERENCES = ("Rest", "Incoming")
SPACES = ("Global", "Object", "Lattice", "Custom")
METHODS = ("Balanced", "Sweep", "Gradient", "Nearest")
COSTS = ("Points", "Surface", "Bending")
BASES = ("Bernstein", "B-Spline", "Blender")
OUTSIDES = ("Keep", "Extend")
JOINTS = ("Free", "C0", "C1", "C2")
AXES = ("X", "Y", "Z")
PIVOTS = ("Bottom", "Centre", "Top")
NEUTRAL = (1.0, 0.0, 0.0, 0.0)
"""Squash, taper, twist and bend that move nothing."""

HEAVIEST = 10.0
"""Default of the weight that a point in full in the vertex group Weights has."""

BSPLINE_DEGREE = 3
"""The volume paper's uniform cubic; a side with fewer than four points takes the highest degree it can hold."""


@dataclass(frozen=True)
class Shaping:
    """Values of the inputs of the panel Animate; angles in radians, the two menus by the names listed above."""

    axis: str = "Z"
    squash: float = 1.0
    taper: float = 0.0
    twist: float = 0.0
    bend: float = 0.0
    bend_direction: float = 0.0
    pivot: str = "Bottom"

    @property
    def is_neutral(self) -> bool:
        """Whether nothing moves, so that the other inputs do not matter."""
        return (self.squash, self.taper, self.twist, self.bend) == NEUTRAL


@dataclass(frozen=True)
class Parts:
    """Which parts of the mesh keep a volume of their own: every closed piece, a vertex group's region (with a target of
    its own), and whether holes count as closed."""

    islands: bool = False
    close_holes: bool = False
    region: str = ""
    region_target: float = 1.0


WHOLE = Parts()
"""One volume, that of the closed mesh."""


@dataclass(frozen=True)
class Settings:
    """Values of the modifier's sockets, with drivers and keys applied. Menus hold the names listed above."""

    strength: float = 1.0
    vertex_group: str = ""
    invert: bool = False
    preserve: float = 1.0
    reference: str = REFERENCES[0]
    target: float = 1.0
    axes: tuple[float, float, float] = (1.0, 1.0, 1.0)
    space: str = SPACES[0]
    method: str = METHODS[0]
    basis: str = BASES[0]
    outside: str = OUTSIDES[0]
    shaping: Shaping = Shaping()
    parts: Parts = WHOLE
    stiffness: str = ""
    where_lost: float = 0.0
    cost: str = COSTS[0]
    unfolded: bool = False
    falloff: float = 0.0
    weights: str = ""
    heaviest: float = HEAVIEST
    joint: str = JOINTS[0]
