# SPDX-License-Identifier: GPL-3.0-or-later
"""Finite but extreme input: refused by name, or computed; never a panic, never NaN."""

import isochor
import meshes
import numpy as np
import pytest
from refusals import refused

BALL = meshes.bumpy_ball(2)


@pytest.mark.parametrize(
    "knots",
    [
        [-1e308] * 4 + [1e308] * 4,
        [-1e308, 0, 0, 0, 1e-10, 1e308, 1e308, 1e308],
        [0, 0, 0, 0, 1e-46, 1, 1, 1, 1],
        [0, 0, 0, 0, 5e-324, 1, 1, 1, 1],
        [0, 0, 0, 0, 1 - 1e-15, 1, 1, 1, 1],
    ],
)
def test_knots_that_float64_cannot_tell_apart(knots):
    shape = (len(knots) - 4,) * 3
    with refused(isochor.LatticeError, "knots"):
        isochor.Lattice(shape=shape, basis="bspline", degree=3, knots=[knots] * 3)


def test_knots_mean_nothing_to_a_bernstein_lattice():
    with refused(isochor.LatticeError, "knots", "Bernstein"):
        isochor.Lattice(shape=(4, 4, 4), knots=[[0, 0, 0, 0, 1, 1, 1, 1]] * 3)


@pytest.mark.parametrize("size", [1e-120, 1e120, 1e200, 1e-200])
def test_edges_beyond_all_measure(size):
    with refused(isochor.LatticeError, "edges between"):
        isochor.Lattice(edges=np.eye(3) * size)


@pytest.mark.parametrize("size", [1e-60, 1e-9, 1e9, 1e60])
def test_large_and_small_worlds_deform_alike(size):
    vertices, triangles = BALL
    lattice = isochor.Lattice(origin=[-1.5 * size] * 3, edges=np.eye(3) * 3 * size)
    binding = lattice.bind(vertices * size, triangles)
    result = binding.preserve(lattice.rest * [1, 0.8, 0.4])
    assert result.error < 1e-12


@pytest.mark.parametrize("size", [1e-200, 1e-3, 1e200])
def test_frames_of_any_length_mean_their_directions(size):
    lattice = isochor.Lattice.around(BALL[0], margin=0.1)
    binding = lattice.bind(*BALL)
    control = lattice.rest * [1, 0.8, 0.4]
    turned = np.array([[1.0, 1, 0], [-1, 1, 0], [0, 0, 1]])
    expected = binding.preserve(control, axes=(1, 1, 0), frame=turned)
    found = binding.preserve(control, axes=(1, 1, 0), frame=turned * size)
    np.testing.assert_allclose(found.control, expected.control, rtol=0, atol=1e-14)


def test_the_axes_as_a_frame_change_nothing():
    lattice = isochor.Lattice.around(BALL[0], margin=0.1)
    binding = lattice.bind(*BALL)
    control = lattice.rest * [1, 0.8, 0.4]
    found, expected = binding.preserve(control, frame=np.eye(3) * 7), binding.preserve(control)
    np.testing.assert_array_equal(found.vertices, expected.vertices)


@pytest.mark.parametrize(("dtype", "far"), [(np.float32, 1e38), (np.float32, 1e300), (np.float64, 1e308)])
def test_control_points_beyond_the_vertices_type(dtype, far):
    lattice = isochor.Lattice.around(BALL[0])
    binding = lattice.bind(BALL[0].astype(dtype), BALL[1])
    control = lattice.rest * far
    for call in (binding.deform, binding.volume, binding.preserve):
        with refused(isochor.LatticeError, "control"):
            call(control)


def test_a_volume_too_large_for_float64():
    lattice = isochor.Lattice.around(BALL[0])
    binding = lattice.bind(*BALL)
    for call in (binding.volume, binding.preserve):
        with refused(isochor.VolumeError, "too large"):
            call(lattice.rest * 1e150)


def test_update_takes_a_lattice_only():
    binding = isochor.Lattice.around(BALL[0]).bind(*BALL)
    with refused(isochor.LatticeError, "isochor.Lattice"):
        binding.update(lattice=5)
