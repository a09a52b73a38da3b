# SPDX-License-Identifier: GPL-3.0-or-later
"""Free-form deformation of the plane: Sederberg's chapter with an interface of its own, and the area kept."""

from __future__ import annotations

import isochor
import laws_papers as papers
import numpy as np
from laws_deforming import Run, law
from laws_of_papers import HIGH, LOW
from numpy.typing import NDArray
from oracle import Array

KINDS = {
    "bernstein": {"shape": (4, 5)},
    "rational": {"shape": (3, 4), "weights": np.random.default_rng(1).uniform(0.2, 5, (3, 4))},
    "bspline": {"shape": (6, 5), "basis": "bspline", "degree": (3, 2), "knots": "uniform"},
    "clamped": {"shape": (6, 5), "basis": "bspline", "degree": 2, "knots": "clamped"},
}
FRAME = {"origin": LOW, "edges": ((HIGH[0] - LOW[0], 0), (0, HIGH[1] - LOW[1]))}
OBLIQUE = {"origin": (-2.0, 1.0), "edges": ((5.0, 1.5), (-1.0, 4.0))}


def disc(rings: int = 6, around: int = 24, hole: float = 0.0) -> tuple[Array, NDArray]:
    """A wavy disc, or ring, of triangles inside the rectangle LOW to HIGH."""
    radii = np.linspace(hole, 1, rings + 1)[0 if hole else 1 :]
    angle = np.arange(around) * 2 * np.pi / around
    outline = 1.1 * (1 + 0.15 * np.cos(3 * angle))
    grid = radii[:, None, None] * np.stack([outline * np.cos(angle), outline * np.sin(angle)], axis=-1)
    points = [*grid.reshape(-1, 2)] if hole else [np.zeros(2), *grid.reshape(-1, 2)]
    start, faces = (0 if hole else 1), []
    for ring in range(len(radii) - 1):
        for i in range(around):
            j = (i + 1) % around
            a, b, c, d = (start + (ring + up) * around + at for up, at in ((0, i), (1, i), (1, j), (0, j)))
            faces += [(a, b, c), (a, c, d)]
    if not hole:
        faces += [(0, 1 + i, 1 + (i + 1) % around) for i in range(around)]
    return np.array(points) + [1.0, 3.5], np.array(faces, dtype=np.int32)


def area(points: NDArray, triangles: NDArray) -> float:
    """Σ of signed triangles in extended precision."""
    a, b, c = np.moveaxis(np.asarray(points, dtype=np.longdouble)[triangles], 1, 0)
    first, second = b - a, c - a
    return float(np.sum(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2)


def posed(lattice, seed: int = 2) -> Array:
    return lattice.rest + np.random.default_rng(seed).uniform(-0.5, 0.5, lattice.rest.shape)


@law({name: KINDS[name] for name in ("bernstein", "rational")})
def sederberg_in_two_dimensions(run: Run, kind: dict) -> None:
    """(14.2), (14.3), (14.1) relative to rest; a point that is not within [0, 1] is not moved, to the bit."""
    lattice = isochor.Lattice2D(**kind, **FRAME)
    m, n = (count - 1 for count in kind["shape"])
    rest = papers.sederberg_grid(LOW, HIGH, m, n)
    np.testing.assert_allclose(lattice.rest, rest, rtol=0, atol=1e-14)
    points = np.random.default_rng(3).uniform((-2, 1), (4, 6), (200, 2)).astype(run.dtype)
    local = np.array([papers.sederberg_local(point.astype(float), LOW, HIGH) for point in points])
    np.testing.assert_allclose(lattice.parameters(points), local, rtol=0, atol=1e-14)
    weights = kind.get("weights", np.ones(kind["shape"]))
    control = posed(lattice)
    moved = lattice.bind(points, device=run.device).deform(control)
    assert moved.dtype == run.dtype
    for point, (s, t), found in zip(points, local, moved):
        if not (0 <= s <= 1 and 0 <= t <= 1):
            np.testing.assert_array_equal(found, point)
            continue
        back = papers.sederberg_blend(rest, weights, s, t)
        expected = papers.sederberg_moved(point.astype(float), control, weights, LOW, HIGH) + point - back
        np.testing.assert_allclose(found, expected, rtol=0, atol=4000 * run.epsilon)


@law({f"{name}-{frame}": (name, frame) for name in KINDS for frame in ("upright", "oblique")})
def the_area_is_kept(run: Run, case: tuple[str, str]) -> None:
    """A disc and a ring, by any shares of x and y; an axis without a share is untouched, to the bit."""
    frame = FRAME if case[1] == "upright" else OBLIQUE
    lattice = isochor.Lattice2D(**KINDS[case[0]], **frame)
    for hole in (0.0, 0.4):
        points, triangles = disc(hole=hole)
        points = points.astype(run.dtype)
        binding = lattice.bind(points, triangles, device=run.device)
        target = area(points, triangles)
        assert abs(binding.area(lattice.rest) / target - 1) <= 1e-6
        control = (posed(lattice) - [1, 3.5]) * [0.6, 0.9] + [1, 3.5]
        assert abs(area(binding.deform(control), triangles) / target - 1) > 0.05
        for axes in ((1, 1), (1, 0), (0, 1), (1, 2)):
            result = binding.preserve(control, axes=axes)
            assert result.vertices.shape == points.shape
            assert result.control.shape == lattice.rest.shape
            allowed = 1e-12 if run.dtype == np.float64 else 1e-6
            assert abs(area(result.vertices, triangles) / target - 1) <= allowed, axes
            still = np.array(axes) == 0
            np.testing.assert_array_equal(result.control[..., still], control[..., still])


@law(KINDS)
def the_plane_at_rest_and_shifted(run: Run, kind: dict) -> None:
    lattice = isochor.Lattice2D(**kind, **OBLIQUE)
    points, triangles = disc()
    points = points.astype(run.dtype)
    binding = lattice.bind(points, triangles, device=run.device)
    np.testing.assert_array_equal(binding.deform(lattice.rest), points)
    moved = binding.deform(lattice.rest + [0.5, -0.25])
    np.testing.assert_allclose(moved, points + [0.5, -0.25], rtol=0, atol=400 * run.epsilon)
    if "weights" in kind:
        return  # `evaluate` is (14.1) itself then, which moves a lattice at rest
    np.testing.assert_allclose(
        lattice.evaluate(lattice.parameters(points), posed(lattice)),
        binding.deform(posed(lattice)), rtol=0, atol=4000 * run.epsilon,
    )  # fmt: skip
