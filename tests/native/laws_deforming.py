# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of laws of free-form deformation, and the lattices that they are put to.

A law is a function of where it is tried (`Run`: device and type of the vertices) and of a case, mostly a lattice.
`TABLE` holds every law with every case that it holds for: tests/native tries it on the CPU, tests/gpu on a GPU.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import lattices
import numpy as np
import pytest
from numpy.typing import NDArray
from oracle import Array, Embedded, Spec


def native(shape, interpolation) -> Spec:
    """A lattice with Blender's basis."""
    return Spec(shape, "blender", interpolation=interpolation)


POLYNOMIAL = {
    "bernstein": Spec((4, 4, 4)),
    "bernstein-mixed": Spec((2, 7, 3)),
    "bernstein-20": Spec((21, 3, 4)),
    "uniform": Spec((6, 5, 7), "bspline", 3, "uniform"),
    "clamped": Spec((6, 5, 7), "bspline", (3, 2, 1), "clamped"),
    "knots": Spec((7, 7, 7), "bspline", 3, lattices.KNOTS),
    "oblique": lattices.FRAMES["oblique"],
}
RATIONAL = {
    "rational-bernstein": lattices.weighted(Spec((4, 4, 4))),
    "rational-mixed": lattices.weighted(Spec((3, 6, 2)), 30.0),
    "rational-uniform": lattices.weighted(Spec((6, 5, 7), "bspline", 3, "uniform")),
    "rational-clamped": lattices.weighted(Spec((6, 5, 7), "bspline", (3, 2, 1), "clamped")),
    "rational-knots": lattices.weighted(Spec((7, 7, 7), "bspline", 3, lattices.KNOTS)),
    "rational-oblique": lattices.weighted(lattices.FRAMES["oblique"]),
    "rational-thin": lattices.weighted(Spec((5, 1, 4))),
}
NATIVE = {
    "blender-linear": native((4, 3, 5), "linear"),
    "blender-cardinal": native((4, 3, 5), "cardinal"),
    "blender-catmull-rom": native((4, 3, 5), "catmull-rom"),
    "blender-bspline": native((4, 3, 5), "bspline"),
    "blender-two": native((2, 2, 2), "bspline"),
    "blender-mixed": native((2, 6, 9), ("cardinal", "linear", "bspline")),
    "blender-thin": native((1, 5, 3), ("bspline", "catmull-rom", "bspline")),
    "blender-oblique": replace(
        lattices.FRAMES["oblique"], basis="blender", interpolation=("bspline", "linear", "cardinal")
    ),
}
EVERY = {**POLYNOMIAL, **RATIONAL, **NATIVE}
OVERSHOOTING = {"cardinal", "catmull-rom"}
HULLS = {  # whose functions are nowhere negative, so that what they blend stays in the hull of what is blended
    name: spec
    for name, spec in EVERY.items()
    if spec.basis != "blender" or not {spec.axis_interpolation(axis) for axis in range(3)} & OVERSHOOTING
}


@dataclass(frozen=True)
class Run:
    """Where a law is tried: a device, and the type of the vertices."""

    device: str
    dtype: type

    @property
    def epsilon(self) -> float:
        """Rounding of a coordinate: of the type, and of float32 passes on a GPU where the type is float32."""
        return float(np.finfo(self.dtype).eps)

    def points(self, spec: Spec, count: int = 150, seed: int = 3) -> NDArray:
        """Points of the domain, its corners among them."""
        return lattices.points_inside(spec, self.dtype, count, seed)

    def bind(self, spec: Spec, points: NDArray, triangles=None, **options):
        """A binding of these points on this device."""
        return spec.build().bind(np.asarray(points, dtype=self.dtype), triangles, device=self.device, **options)

    def deform(self, spec: Spec, points: NDArray, control: Array, **options) -> NDArray:
        """Deformed points; the device is the one asked for, whatever the lattice is."""
        binding = self.bind(spec, points, **options)
        out = binding.deform(control)
        assert binding.device == self.device
        return out.astype(float)

    def room(self, spec: Spec, *controls: Array) -> float:
        """Absolute error to allow in a coordinate."""
        size = sum(float(np.abs(control).max()) for control in (*controls, spec.rest))
        return spec.rounding(np.array(size), self.epsilon)


def oracle(spec: Spec, points: NDArray, control: Array, **options) -> Array:
    """The same by the dense textbook."""
    return Embedded.of(spec, points, np.zeros((0, 3), int), **options).deform(control)


Law = Callable[[Run, Any], None]
TABLE: list = []


def law(over: dict[str, Any]) -> Callable[[Law], Law]:
    """Puts a law into the table, with each of these cases."""

    def put(check: Law) -> Law:
        TABLE.extend(pytest.param(check, case, id=f"{check.__name__}-{name}") for name, case in over.items())
        return check

    return put
