# SPDX-License-Identifier: GPL-3.0-or-later
"""What Hoff, Ferrier, Sederberg and PyGeM print, against the library on every device."""

from __future__ import annotations

import isochor
import lattices
import laws_papers as papers
import numpy as np
from laws_deforming import Run, law
from oracle import Spec

TURN = lattices.rotation((2, -1, 3), 1.1)
CENTRE, HALVES = np.array([0.4, -0.7, 1.5]), np.array([0.6, 1.4, 0.25])
INTERVALS = {"1x1x1": (1, 1, 1), "3x3x3": (3, 3, 3), "4x1x6": (4, 1, 6), "2x12x3": (2, 12, 3), "20x2x2": (20, 2, 2)}


def box_points(run: Run, count: int = 40):
    """Points inside Hoff's box, in the world."""
    local = np.random.default_rng(1).uniform(-1, 1, (count, 3)) * HALVES
    return (CENTRE + local @ TURN).astype(run.dtype)


@law(INTERVALS)
def hoff(run: Run, intervals: tuple[int, int, int]) -> None:
    """Oriented box, stepped lattice, projection, recursive subdivision: any number of intervals along each axis."""
    origin, rest = papers.hoff_lattice(CENTRE, TURN, HALVES, intervals)
    lattice = isochor.Lattice.box(CENTRE, TURN, HALVES, shape=tuple(n + 1 for n in intervals))
    np.testing.assert_allclose(lattice.rest, rest, rtol=0, atol=1e-13)
    points = box_points(run)
    stu = np.array([papers.hoff_stu(point, origin, TURN, HALVES) for point in points])
    np.testing.assert_allclose(lattice.parameters(points), stu, rtol=0, atol=1e-14 / HALVES.min())
    control = rest + np.random.default_rng(2).uniform(-0.3, 0.3, rest.shape)
    expected = np.array([papers.pt_in_lattice(*place, control) for place in stu])
    binding = lattice.bind(points, device=run.device)
    moved = binding.deform(control)
    assert binding.device == run.device
    room = Spec(rest.shape[:3]).rounding(4.0, run.epsilon) / HALVES.min()
    np.testing.assert_allclose(moved, expected, rtol=0, atol=room)


@law({"": None})
def hoffs_box_takes_axes_of_any_length(run: Run, _: None) -> None:
    """Axes are directions: their lengths do not count, half-widths do."""
    shape, stretched = (4, 3, 5), TURN * [[3.0], [0.2], [70.0]]
    plain, long = (isochor.Lattice.box(CENTRE, axes, HALVES, shape=shape) for axes in (TURN, stretched))
    np.testing.assert_allclose(long.rest, plain.rest, rtol=0, atol=1e-14)
    control = plain.rest * 1.1 + 0.2
    points = box_points(run)
    here, there = (lattice.bind(points, device=run.device).deform(control) for lattice in (plain, long))
    np.testing.assert_allclose(there, here, rtol=0, atol=64 * run.epsilon)


@law({"": Spec((4, 4, 4))})
def ferriers_volume(run: Run, spec: Spec) -> None:
    """Listing 3 as it must be read agrees; letter by letter it does not."""
    points, control = run.points(spec, 40), lattices.noisy(spec, 0.7)
    places = np.clip(points.astype(float), 0, 1)
    moved = run.deform(spec, points, control)
    expected = [papers.eval_volume(control, *place) for place in places]
    np.testing.assert_allclose(moved, expected, rtol=0, atol=run.room(spec, control))
    printed = np.array([papers.eval_volume_as_printed(control, *place) for place in places])
    assert np.abs(printed - moved).max() > 1


@law({"": Spec((4, 4, 4))})
def ferriers_curve_and_surface(run: Run, spec: Spec) -> None:
    """Listings 1 and 2 are what a block does to its edge and to its face."""
    control = lattices.noisy(spec, 0.7)
    t = np.random.default_rng(3).random((30, 2)).astype(run.dtype)
    zero = np.zeros(len(t))
    edge = run.deform(spec, np.stack([zero, zero, t[:, 0]], axis=1), control)
    expected = [papers.eval_curve(control[0, 0], float(u)) for u in t[:, 0]]
    np.testing.assert_allclose(edge, expected, rtol=0, atol=run.room(spec, control))
    face = run.deform(spec, np.stack([t[:, 0], zero + 1, t[:, 1]], axis=1), control, outside="extend")
    expected = [papers.eval_surface(control[:, 3], float(u), float(v)) for u, v in t]
    np.testing.assert_allclose(face, expected, rtol=0, atol=run.room(spec, control))


LOW, HIGH = (-1.0, 2.0), (3.0, 5.0)


@law({f"{m}x{n}-{kind}": (m, n, kind) for m, n in ((2, 2), (3, 1), (5, 4)) for kind in ("plain", "rational")})
def sederberg(run: Run, case: tuple[int, int, str]) -> None:
    """(14.1)-(14.3) in the plane; a point that is not in the rectangle is not moved, to the bit.

    Unequal weights move a lattice at rest under (14.1): the library moves points by what control points have moved,
    X(P) − X(P at rest), so that rest is the identity.
    """
    m, n, kind = case
    rest = papers.sederberg_grid(LOW, HIGH, m, n)
    random = np.random.default_rng(4)
    weights = random.uniform(0.2, 5, rest.shape[:2]) if kind == "rational" else np.ones(rest.shape[:2])
    control = rest + random.uniform(-1, 1, rest.shape)
    points = random.uniform((-2, 1), (4, 6), (200, 2)).astype(run.dtype).astype(float)
    moved = in_the_plane(run, (m + 1, n + 1), weights if kind == "rational" else None, points, control - rest)
    for point, found in zip(points, moved):
        s, t = papers.sederberg_local(point, LOW, HIGH)
        if not (0 <= s <= 1 and 0 <= t <= 1):
            np.testing.assert_array_equal(found, point)
            continue
        expected = papers.sederberg_moved(point, control, weights, LOW, HIGH)
        expected = expected + point - papers.sederberg_blend(rest, weights, s, t)
        np.testing.assert_allclose(found, expected, rtol=0, atol=4000 * run.epsilon)


def in_the_plane(run: Run, shape, weights, points, displacement):
    """(V, 2) points in the rectangle LOW to HIGH of a lattice one point thick, moved."""
    width, height = np.subtract(HIGH, LOW)
    heavy = None if weights is None else weights[..., None]
    spec = Spec((*shape, 1), origin=(*LOW, 0.0), edges=((width, 0, 0), (0, height, 0), (0, 0, 1)), weights=heavy)
    flat = np.pad(points, ((0, 0), (0, 1)), constant_values=0.5)
    control = spec.build().rest + np.pad(displacement, ((0, 0), (0, 0), (0, 1)))[:, :, None]
    moved = run.deform(spec, flat, control)
    np.testing.assert_array_equal(moved[:, 2], 0.5)
    return moved[:, :2]


@law({f"{n}x{m}x{o}": (n, m, o) for n, m, o in ((2, 2, 2), (3, 5, 2), (6, 3, 4))})
def pygem(run: Run, shape: tuple[int, int, int]) -> None:
    """Displacement weights in box lengths; a turned box; points outside stay."""
    origin, lengths = np.array([0.3, -0.2, 0.1]), np.array([1.5, 0.7, 2.0])
    mu = np.random.default_rng(5).uniform(-0.4, 0.4, (*shape, 3))
    local = np.random.default_rng(6).uniform(-0.3, 1.3, (300, 3))
    points = (origin + (local * lengths) @ TURN).astype(run.dtype)
    expected = papers.pygem_moved(points, origin, lengths, TURN, mu)
    lattice = isochor.Lattice(shape=shape, origin=origin, edges=TURN * lengths[:, None])
    control = lattice.rest + (mu * lengths) @ TURN
    binding = lattice.bind(points, outside="keep", device=run.device)
    moved = binding.deform(control)
    assert binding.device == run.device
    np.testing.assert_allclose(moved, expected, rtol=0, atol=2000 * run.epsilon)
    still = np.any((local < -1e-5) | (local > 1 + 1e-5), axis=1)
    np.testing.assert_array_equal(moved[still], points[still])
