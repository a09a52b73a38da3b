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


@law({name: CASES[name] for name in ("cube-bernstein", "lemon-uniform", "torus-rational-bernstein")})
def pins_and_frozen_points_of_a_surface(run: Run, case: tuple[Body, Spec]) -> None:
    """Pins hold places of the surface, by vertex or by face; frozen control points do not move, to the bit."""
    body, spec = case
    points, tessellation = tessellated(run, body, spec, 4)
    binding = spec.build().bind(
        points, tessellation.triangles, surface=tessellation.surface, outside="extend", device=run.device
    )
    control = spec.centre + (lattices.noisy(spec, 0.05) - spec.centre) * [1.0, 0.9, 0.8]
    weights = np.ones(spec.shape)
    weights[0] = np.inf
    deformed = tessellation.surface.apply(binding.deform(control).astype(float))
    far = int(np.argmax(deformed[:, 0]))
    face, shares = len(tessellation.triangles) // 2, np.array([0.2, 0.3, 0.5])
    middle = shares @ deformed[tessellation.triangles[face]]
    target = textbook.volume(tessellation.surface.apply(points), tessellation.triangles, spec.centre)
    allowed = 1e-12 if run.dtype == np.float64 else 1e-6
    for pins, places in (
        (([far], [deformed[far] + [0.03, 0.01, -0.02]]), lambda s: s[far]),
        (
            isochor.Pins([face], [middle + [0.0, 0.02, 0.01]], [shares]),
            lambda s: shares @ s[tessellation.triangles[face]],
        ),
    ):
        wanted = pins[1][0] if isinstance(pins, tuple) else middle + [0.0, 0.02, 0.01]
        for method in ("balanced", "nearest"):
            result = binding.preserve(control, pins=pins, weights=weights, method=method)
            np.testing.assert_allclose(places(result.surface), wanted, rtol=0, atol=4 * allowed)
            np.testing.assert_array_equal(result.control[0], control[0])
            found = textbook.volume(result.surface, tessellation.triangles, spec.centre)
            assert abs(found - target) <= allowed * target


@law({name: CASES[name] for name in ("cube-uniform", "torus-bernstein")})
def two_bodies_of_one_surface(run: Run, case: tuple[Body, Spec]) -> None:
    """Two patch models side by side over one set of points: each keeps its own volume."""
    body, spec = case
    both = np.concatenate([body.points * 0.45, body.points * 0.45 + 0.5])
    patches = np.concatenate([body.patches, body.patches + len(body.points)])
    points = lattices.fitted(spec, both).astype(run.dtype)
    tessellation = isochor.Patches(points.astype(float), patches).tessellate(3)
    binding = spec.build().bind(
        points, tessellation.triangles, surface=tessellation.surface, bodies="islands", device=run.device
    )
    assert binding.body_count == 2
    result = binding.preserve(spec.centre + (lattices.noisy(spec, 0.05) - spec.centre) * [1.0, 0.9, 0.6])
    at_rest = tessellation.surface.apply(points)
    for number in range(2):
        faces = tessellation.triangles[binding.body_of_triangle == number]
        target = textbook.volume(at_rest, faces, spec.centre)
        found = textbook.volume(result.surface, faces, spec.centre)
        assert abs(found / target - 1) <= (1e-12 if run.dtype == np.float64 else 4e-6)
