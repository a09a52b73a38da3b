# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces whose vertices are combinations of the points that move: patches, subdivision; their volume kept."""

from __future__ import annotations

from dataclasses import replace

import isochor
import lattices
import numpy as np
import oracle as textbook
from corrections import Correction, Solid
from laws_bodies import Body, lemon, lidded, torus
from laws_deforming import EVERY, Run, law
from oracle import Array, Embedded, Spec

BODIES = {"cube": lidded(4), "quadratic": lidded(3), "torus": torus(), "lemon": lemon()}
SPECS = ("bernstein", "uniform", "rational-bernstein", "blender-bspline", "oblique")
CASES = {f"{body}-{name}": (BODIES[body], EVERY[name]) for body in BODIES for name in SPECS}


def dense(surface: isochor.Surface, count: int) -> Array:
    """(T, P) of the surface's rows."""
    return surface.apply(np.eye(count))


def tessellated(run: Run, body: Body, spec: Spec, level: int = 3):
    """Points in the lattice's domain, in the run's type, and the tessellation."""
    points = lattices.fitted(spec, body.points).astype(run.dtype)
    return points, isochor.Patches(points.astype(float), body.patches).tessellate(level)


@law(CASES)
def only_the_points_move_and_the_surface_s_volume_is_kept(run: Run, case: tuple[Body, Spec]) -> None:
    """Volume measured on the tessellation that the moved patch points give."""
    body, spec = case
    points, tessellation = tessellated(run, body, spec)
    binding = spec.build().bind(
        points, tessellation.triangles, surface=tessellation.surface, outside="extend", device=run.device
    )
    rows = dense(tessellation.surface, len(points))
    control = spec.centre + (lattices.noisy(spec, 0.08) - spec.centre) * [1.1, 0.9, 0.6]
    target = textbook.volume(rows @ points, tessellation.triangles, spec.centre)
    assert abs(binding.reference_volume / target - 1) <= 1e-6
    for method in ("balanced", "sweep", "gradient", "nearest"):
        result = binding.preserve(control, method=method)
        assert result.vertices.shape == points.shape
        assert result.surface.shape == (len(rows), 3)
        size = np.abs(result.vertices).max()
        np.testing.assert_allclose(result.surface, rows @ result.vertices, rtol=0, atol=64 * run.epsilon * size)
        found = textbook.volume(result.surface, tessellation.triangles, spec.centre)
        allowed = textbook.tolerance(result.surface.astype(run.dtype), tessellation.triangles, spec.centre, target)
        assert abs(found - target) <= allowed * abs(target), method
    np.testing.assert_allclose(
        binding.deform(result.control), result.vertices, rtol=0, atol=run.room(spec, result.control)
    )


@law({name: CASES[name] for name in ("cube-bernstein", "torus-rational-bernstein", "lemon-blender-bspline")})
def the_correction_is_the_papers_with_composed_rows(run: Run, case: tuple[Body, Spec]) -> None:
    """Rows of the surface times rows of the points in B's place."""
    if run.dtype != np.float64:
        return
    body, spec = case
    points, tessellation = tessellated(run, body, spec)
    rows = dense(tessellation.surface, len(points))
    embedded = Embedded.of(spec, points, tessellation.triangles, outside="extend")
    composed = replace(embedded, rows=rows @ embedded.rows, constant=rows @ embedded.constant)
    control = spec.centre + (lattices.noisy(spec, 0.08) - spec.centre) * [1.1, 0.9, 0.6]
    expected = Correction(Solid.of(composed), control).sweep() - control
    binding = spec.build().bind(
        points, tessellation.triangles, surface=tessellation.surface, outside="extend", device=run.device
    )
    found = binding.preserve(control, method="sweep").control - control
    assert np.linalg.norm(found - expected) <= (1e-8 if run.device == "cpu" else 1e-4) * np.linalg.norm(expected)
