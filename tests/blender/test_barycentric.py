# SPDX-License-Identifier: GPL-3.0-or-later
"""The point of a surface that is nearest to another, against all that the surface has."""

import numpy as np
import pytest
import scenes

GRID = np.array([(i, j, 40 - i - j) for i in range(41) for j in range(41 - i)]) / 40.0
"""Barycentric coordinates of points all over a triangle."""


def nearest(point, corners):
    index, weights = scenes.part("core.barycentric").nearest(np.asarray(point, float), np.asarray(corners, float))
    assert (weights >= 0.0).all()
    assert weights.sum() == pytest.approx(1.0, abs=1e-14)
    return index, weights, weights @ np.asarray(corners, float)[index]


@pytest.mark.parametrize("seed", range(40))
def test_no_point_of_any_triangle_is_nearer(seed):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(12, 3, 3)) * 10.0 ** random.uniform(-3, 3)
    if seed % 4 == 0:
        corners[::2, 2] = corners[::2, 0] + random.uniform(-1, 2) * (corners[::2, 1] - corners[::2, 0])
    if seed % 5 == 0:
        corners[:, 1] = corners[:, 0]
    point = random.normal(size=3) * np.abs(corners).max()
    index, _weights, found = nearest(point, corners)
    size = np.abs(corners).max()
    distances = np.linalg.norm(np.einsum("gi,fik->fgk", GRID, corners) - point, axis=2)
    assert np.linalg.norm(found - point) <= distances.min() + 1e-12 * size
    # Coarser by the grid than by anything that could be wrong here.
    assert np.linalg.norm(found - point) >= distances[index].min() - 0.1 * size


def test_points_of_the_triangle_are_found_themselves():
    random = np.random.default_rng(3)
    corners = random.normal(size=(1, 3, 3))
    for weights in (*np.eye(3), (0.2, 0.5, 0.3), (0.5, 0.5, 0.0)):
        _index, given, found = nearest(np.asarray(weights) @ corners[0], corners)
        assert np.allclose(given, weights, atol=1e-14)
        assert np.allclose(found, np.asarray(weights) @ corners[0], atol=1e-15)


def test_a_point_above_a_corner_is_that_corner_alone():
    _index, weights, _found = nearest((-1.0, -2.0, 0.5), [[(0, 0, 0), (1, 0, 0), (0, 1, 0)]])
    assert weights.tolist() == [1.0, 0.0, 0.0]
