# SPDX-License-Identifier: GPL-3.0-or-later
"""What the animator set on one Volume Lattice modifier, as evaluated for one frame."""

from dataclasses import dataclass

REFERENCES = ("Rest", "Incoming")
SPACES = ("Global", "Object", "Lattice")
METHODS = ("Balanced", "Sweep")
BASES = ("Bernstein", "B-Spline")
OUTSIDES = ("Keep", "Extend")

BSPLINE_DEGREE = 3
"""The volume paper's uniform cubic; a side with fewer than four points takes the highest degree it can hold."""


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
