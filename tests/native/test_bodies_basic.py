# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bodies through the Python module: names, shapes, dtypes and refusals of `bodies`, `caps` and `target`."""

import isochor
import meshes
import numpy as np
import pytest
from isochor import MeshError, VolumeError
from refusals import refused

LATTICE = isochor.Lattice(shape=(5, 5, 5), basis="bspline")
BALL, BOX = meshes.icosphere(2, 0.25, (0.3, 0.4, 0.5)), meshes.box(2, (0.6, 0.6, 0.3), (0.9, 0.9, 0.8))
BOTH = meshes.joined(BALL, BOX)
SQUASHED = (LATTICE.rest - 0.5) * [1.1, 1.0, 0.5] + 0.5


def own(mesh) -> float:
    """Signed volume of a closed mesh."""
    a, b, c = np.moveaxis(np.asarray(mesh[0], float)[mesh[1]], 1, 0)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient", "nearest"])
def test_each_island_keeps_its_volume_and_the_results_say_so(dtype, method):
    tolerance = 1e-12 if dtype == np.float64 else 1e-6
    binding = LATTICE.bind(BOTH[0].astype(dtype), BOTH[1], bodies="islands")
    assert binding.body_count == 2
    np.testing.assert_array_equal(binding.body_of_triangle, np.repeat([0, 1], [len(BALL[1]), len(BOX[1])]))
    assert binding.body_of_triangle.dtype == np.int32
    np.testing.assert_allclose(binding.reference_volumes, [own(BALL), own(BOX)], rtol=10 * tolerance)
    result = binding.preserve(SQUASHED, method=method)
    np.testing.assert_allclose(result.volumes, binding.reference_volumes, rtol=tolerance)
    np.testing.assert_allclose(result.targets, binding.reference_volumes, rtol=1e-14)
    assert result.volumes.dtype == result.targets.dtype == np.float64
    np.testing.assert_allclose(binding.volumes(result.control), result.volumes, rtol=10 * tolerance)
    assert result.volume == pytest.approx(own((result.vertices, BOTH[1])), rel=10 * tolerance)
    assert result.error == pytest.approx(np.abs(result.volumes / result.targets - 1).max(), abs=1e-15)


def test_the_bodies_outlive_an_update():
    labels = np.repeat([1, 0], [len(BALL[1]), len(BOX[1])])
    binding = LATTICE.bind(*BOTH, bodies=labels)
    binding.update(BOTH[0] * 0.9)
    np.testing.assert_array_equal(binding.body_of_triangle, labels)
    np.testing.assert_allclose(binding.reference_volumes, np.array([own(BOX), own(BALL)]) * 0.9**3, rtol=1e-12)


def test_a_number_is_shared_and_an_array_is_taken():
    binding = LATTICE.bind(*BOTH, bodies="islands")
    rest = binding.reference_volumes
    np.testing.assert_allclose(binding.preserve(SQUASHED, target=2 * rest.sum()).volumes, 2 * rest, rtol=1e-12)
    each = rest * [1.5, 0.5]
    np.testing.assert_allclose(binding.preserve(SQUASHED, target=each).volumes, each, rtol=1e-12)
    for target in ([1.0], [1.0, 2.0, 3.0], [[1.0, 2.0]], ["1", "2"], "1"):
        with refused(VolumeError, "target"):
            binding.preserve(SQUASHED, target=target)


def test_caps_close_holes_and_borders():
    halves = (BALL[0][BALL[1]].mean(axis=1)[:, 2] > 0.5).astype(np.int8)
    split = LATTICE.bind(*BALL, bodies=halves)
    assert split.reference_volume == pytest.approx(own(BALL), rel=1e-13)
    assert LATTICE.bind(BALL[0], BALL[1][halves == 0], caps=True).reference_volume == pytest.approx(
        split.reference_volumes[0], rel=1e-13
    )
    np.testing.assert_allclose(split.preserve(SQUASHED).volumes, split.reference_volumes, rtol=1e-12)
    holed = LATTICE.bind(BALL[0], BALL[1][1:])
    with refused(MeshError, 3, "hole", tuple(BALL[1][0].tolist())):
        holed.preserve(SQUASHED)


def test_bodies_that_are_none_are_refused():
    count = len(BALL[1])
    for bodies in ("pieces", [0], np.full(count, 0.5), np.full(count, 2**40), np.full(count, -2), 3):
        with refused(MeshError, "bodies"):
            LATTICE.bind(*BALL, bodies=bodies)
