# SPDX-License-Identifier: GPL-3.0-or-later
"""What every lattice must do whatever its basis: identity at rest, affine maps reproduced, hull, equivariance."""

import lattices
import numpy as np
import pytest
from lattices import SOLID, THIN
from oracle import Spec

EVERY = {**SOLID, **THIN}
DTYPES = [np.float64, np.float32]
each_solid = pytest.mark.parametrize("spec", SOLID.values(), ids=SOLID)
each_lattice = pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
each_dtype = pytest.mark.parametrize("dtype", DTYPES, ids=["float64", "float32"])


def bound(spec: Spec, points, **options):
    return spec.build().bind(points, device="cpu", **options)


@each_lattice
def test_rest_points_stand_at_the_greville_abscissae(spec):
    rest = spec.build().rest
    assert rest.dtype == np.float64
    assert rest.shape == (*spec.shape, 3)
    several = np.array(spec.shape) > 1  # where one control point of an axis stands is the library's choice
    along = (rest - spec.rest) @ np.linalg.inv(np.asarray(spec.edges, dtype=float))
    np.testing.assert_allclose(along[..., several], 0, atol=1e-14)


@each_lattice
@each_dtype
def test_rest_lattice_is_the_identity(spec, dtype):
    points = lattices.points_inside(spec, dtype)
    out = bound(spec, points).deform(spec.build().rest)
    assert out.dtype == dtype
    atol = spec.rounding(np.abs(spec.rest).max(), float(np.finfo(dtype).eps))
    np.testing.assert_allclose(out, points, rtol=0, atol=atol)


@each_lattice
def test_moving_the_lattice_moves_the_points_with_it(spec):
    """Partition of unity: the weights of every point sum to one."""
    points, offset = lattices.points_inside(spec), np.array([3.0, -2.0, 0.5]) * np.abs(spec.edges).max()
    out = bound(spec, points).deform(spec.build().rest + offset)
    np.testing.assert_allclose(out, points + offset, rtol=0, atol=spec.rounding(spec.rest + offset, 2.3e-16))


@each_solid
@each_dtype
@pytest.mark.parametrize("seed", [1, 2])
def test_any_affine_map_of_the_control_points_is_that_affine_map(spec, dtype, seed):
    linear, offset = lattices.affine(seed)
    points = lattices.points_inside(spec, dtype)
    control = spec.rest @ linear.T + offset
    out = bound(spec, points).deform(control)
    atol = spec.rounding(max(np.abs(control).max(), np.abs(spec.rest).max()), float(np.finfo(dtype).eps))
    np.testing.assert_allclose(out, points.astype(float) @ linear.T + offset, rtol=0, atol=atol)


@each_solid
def test_a_singular_affine_map_flattens(spec):
    control = spec.rest.copy()
    control[..., 2] = 0.0
    flat = bound(spec, lattices.points_inside(spec)).deform(control)
    np.testing.assert_allclose(flat[:, 2], 0, rtol=0, atol=spec.rounding(spec.rest, 2.3e-16))


@each_solid
def test_points_stay_in_the_convex_hull_of_the_control_points(spec):
    control = lattices.noisy(spec, 0.7)
    out = bound(spec, lattices.points_inside(spec)).deform(control)
    room = spec.rounding(control, 2.3e-16)
    for direction in [*np.eye(3), *np.random.default_rng(4).normal(size=(20, 3))]:
        direction = direction / np.linalg.norm(direction)
        reach = control.reshape(-1, 3) @ direction
        assert (out @ direction).max() <= reach.max() + room
        assert (out @ direction).min() >= reach.min() - room


@each_solid
def test_deforming_commutes_with_rotating_and_moving_the_whole_scene(spec):
    turn, offset = lattices.rotation(), np.array([1.0, -2.0, 0.5]) * np.abs(spec.edges).max()
    points, control = lattices.points_inside(spec), lattices.noisy(spec)
    there = bound(spec.moved(turn, offset), points @ turn.T + offset, outside="extend")
    out = there.deform(control @ turn.T + offset)
    here = bound(spec, points, outside="extend").deform(control)
    # "extend": a corner may fall a rounding error outside the turned domain, and must move all the same
    stretch = np.abs(spec.edges).max() / np.abs(np.linalg.det(np.asarray(spec.edges, dtype=float))) ** (1 / 3)
    atol = spec.rounding(np.abs(control).max() + np.abs(offset).max(), 4e-16) * stretch**3
    np.testing.assert_allclose(out, here @ turn.T + offset, rtol=0, atol=atol)


def test_the_corners_of_a_clamped_lattice_are_its_corner_control_points():
    for spec in (Spec((4, 3, 6)), Spec((5, 6, 7), "bspline", (2, 3, 4), "clamped")):
        control = lattices.noisy(spec, 0.5)
        out = bound(spec, np.array([[0, 0, 0], [1, 1, 1], [1, 0, 1]], dtype=float)).deform(control)
        np.testing.assert_allclose(out, [control[0, 0, 0], control[-1, -1, -1], control[-1, 0, -1]], atol=1e-14)


@pytest.mark.parametrize("basis", ["bernstein", "uniform", "clamped"])
def test_a_mesh_a_million_units_away_deforms_like_one_at_home(basis):
    home = Spec((6, 6, 6)) if basis == "bernstein" else Spec((6, 6, 6), "bspline", 3, basis)
    offset = np.array([1e6, -1e6, 1e6])
    away = home.moved(offset=offset)
    # coordinates in multiples of 2^-30 are exact at both places
    points = np.round(lattices.points_inside(home) * 2**30) / 2**30
    control = np.round(lattices.noisy(home) * 2**30) / 2**30
    out = bound(away, points + offset).deform(control + offset)
    np.testing.assert_allclose(out - offset, bound(home, points).deform(control), rtol=0, atol=4 * 1e6 * 2.3e-16)


def test_a_plane_lattice_moves_points_by_its_displacement_whatever_their_height():
    spec = THIN["plane"]
    points = lattices.points_inside(spec)
    control = spec.build().rest
    control = control + [0.0, 0.0, 1.0] * np.square(control[..., :1])
    out = bound(spec, points).deform(control)
    flat = points * [1, 1, 0]
    lifted = bound(spec, flat).deform(control)
    np.testing.assert_allclose(out - points, lifted - flat, rtol=0, atol=1e-14)
    assert np.ptp(out[:, 2] - points[:, 2]) > 0.5
