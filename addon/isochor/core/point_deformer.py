# SPDX-License-Identifier: GPL-3.0-or-later
"""Control points deformed by a lattice; where they make a closed surface, that keeps its volume."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import isochor

from . import problem
from .grid import Grid, build_lattice
from .settings import Settings
from .shell import Shell
from .solver import METHODS, OUTSIDES

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Deformed:
    """``points`` (P, 3) float64; ``surface`` (T, 3) of the shell over them, with its ``volume`` and the ``target`` that
    it was to have, None where no volume was kept; ``trouble`` says in plain words why not, if it should have been."""

    points: Array = field(repr=False)
    surface: Array | None = field(default=None, repr=False)
    volume: float | None = None
    target: float | None = None
    trouble: str = ""


def deform(
    points: Array, shell: Shell | None, grid: Grid, control: Array, settings: Settings, frame: Array | None
) -> Deformed:
    """Moves points (P, 3) as the control points (nu, nv, nw, 3) of ``grid`` say, all in the object's space. What the
    native library finds wrong with the points or the lattice is raised as ``Problem``, and what it finds wrong with the
    surface told as ``trouble``. ``frame`` (3, 3): rows that x, y and z of the settings' axes mean, or None."""
    keeps = shell is not None and settings.preserve > 0.0
    try:
        binding = _bind(points, shell if keeps else None, grid, settings)
        if not keeps:
            return Deformed(np.asarray(binding.deform(control)))
        return _preserved(binding, control, settings, frame)
    except isochor.Error as error:
        raise problem.Problem(problem.sentence(error)) from error


def _bind(points: Array, shell: Shell | None, grid: Grid, settings: Settings) -> isochor.Binding:
    lattice = build_lattice(grid)
    influence = None if settings.strength >= 1.0 else np.full(len(points), settings.strength)
    outside = OUTSIDES[settings.outside]
    if shell is None:
        return lattice.bind(points, device="cpu", outside=outside, influence=influence)
    surface = isochor.Surface(shell.offsets, shell.columns, shell.weights, point_count=len(points))
    return lattice.bind(
        points,
        shell.triangles,
        device="cpu",
        outside=outside,
        influence=influence,
        caps=settings.parts.close_holes,
        surface=surface,
    )


def _preserved(binding: isochor.Binding, control: Array, settings: Settings, frame: Array | None) -> Deformed:
    try:
        result = binding.preserve(
            control,
            axes=settings.axes,
            frame=frame,
            method=METHODS[settings.method],
            target=binding.reference_volume * settings.target,
            amount=settings.preserve,
        )
    except isochor.Error as error:
        return Deformed(np.asarray(binding.deform(control)), trouble=problem.sentence(error))
    surface = None if result.surface is None else np.asarray(result.surface)
    return Deformed(np.asarray(result.vertices), surface, float(result.volume), float(result.target))
