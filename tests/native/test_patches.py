# SPDX-License-Identifier: GPL-3.0-or-later
"""Bézier patches and surfaces over points through the Python module."""

import isochor
import meshes
import numpy as np
import oracle
import pytest
from isochor import MeshError, PinError
from patch_models import casteljau, urn
from refusals import refused

LATTICE = isochor.Lattice(shape=(5, 4, 5), basis="bspline")
SQUASHED = (LATTICE.rest - 0.5) * [1.1, 0.9, 0.5] + 0.5


def own(vertices, triangles) -> float:
    return float(oracle.volume(np.asarray(vertices, float), triangles))


@pytest.mark.parametrize("degree", [1, 2, 3, 12])
def test_places_derivatives_and_normals_are_those_of_the_control_points(degree):
    points, indices = urn(degree)
    patches = isochor.Patches(points, indices)
    assert (len(patches), patches.degree) == (8, (degree, degree))
    np.testing.assert_array_equal(patches.patches, indices)
    uv = np.random.default_rng(1).random((20, 2))
    for patch in range(8):
        expected = [casteljau(points[indices[patch]], u, v) for u, v in uv]
        np.testing.assert_allclose(patches.evaluate(patch, uv), expected, atol=1e-14)
    which = np.arange(20) % 8
    slopes = patches.derivatives(which, uv)
    step = 1e-6 * np.eye(2)
    for along in range(2):
        ahead, behind = (patches.evaluate(which, np.clip(uv + s * step[along], 0, 1)) for s in (1, -1))
        np.testing.assert_allclose(slopes[:, along], (ahead - behind) / 2e-6, atol=1e-6)
    normals = np.cross(slopes[:, 0], slopes[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(patches.normals(which, uv), normals, atol=1e-12)


@pytest.mark.parametrize("level", [1, 2, 5, 16])
def test_a_closed_model_is_closed_at_every_level(level):
    points, indices = urn()
    mesh = isochor.Patches(points, indices).tessellate(level)
    a, b, c = mesh.triangles.T
    edges = np.concatenate([np.stack(pair, 1) for pair in ((a, b), (b, c), (c, a))])
    assert len(np.unique(edges, axis=0)) == len(edges)
    np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    assert len(mesh.surface) - len(mesh.triangles) // 2 == 2
    vertices = mesh.surface.apply(points)
    assert own(vertices, mesh.triangles) != 0
    places = isochor.Patches(points, indices).evaluate(mesh.patch_of_vertex, mesh.parameters)
    np.testing.assert_allclose(vertices, places, atol=1e-14)
    assert mesh.quads.shape == (8 * level * level, 4)
    assert (mesh.quads[:, 3] < 0).sum() == 8 * level
    assert mesh.triangles.dtype == mesh.quads.dtype == mesh.patch_of_vertex.dtype == np.int32
    np.testing.assert_array_equal(np.bincount(mesh.patch_of_quad), [level * level] * 8)


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("device", ["cpu", "gpu"])
@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient", "nearest"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_tessellation_keeps_its_volume_by_its_control_points_alone(dtype, device, method):
    points, indices = urn()
    points = points.astype(dtype)
    mesh = isochor.Patches(points, indices).tessellate(6)
    binding = LATTICE.bind(points, mesh.triangles, device=device, surface=mesh.surface)
    target = own(mesh.surface.apply(points), mesh.triangles)
    assert binding.reference_volume == pytest.approx(target, rel=1e-12)
    result = binding.preserve(SQUASHED, method=method)
    assert result.vertices.shape == points.shape
    assert result.vertices.dtype == dtype
    np.testing.assert_allclose(result.surface, mesh.surface.apply(result.vertices), atol=1e-15)
    tolerance = 1e-12 if dtype == np.float64 else 1e-6
    assert own(result.surface, mesh.triangles) == pytest.approx(target, rel=tolerance)
    assert result.volume == pytest.approx(target, rel=tolerance)
    assert result.error < tolerance
    assert result.device == "cpu"
    # The tessellation is that of patches with the moved points.
    again = isochor.Patches(result.vertices, indices).tessellate(6)
    np.testing.assert_allclose(again.surface.apply(result.vertices), result.surface, atol=1e-15)
    np.testing.assert_array_equal(binding.deform(result.control), result.vertices)


def test_pins_hold_vertices_of_the_surface():
    points, indices = urn()
    mesh = isochor.Patches(points, indices).tessellate(5)
    binding = LATTICE.bind(points, mesh.triangles, surface=mesh.surface)
    start = mesh.surface.apply(points)
    held = np.array([3, len(start) // 2])
    result = binding.preserve(SQUASHED, pins=(held, start[held] + [[0.03, 0, 0], [0, 0, 0]]))
    np.testing.assert_allclose(result.surface[held], start[held] + [[0.03, 0, 0], [0, 0, 0]], atol=1e-13)
    assert result.error < 1e-12
    with refused(PinError, len(start)):
        binding.preserve(SQUASHED, pins=([len(start)], [[0.0, 0.0, 0.0]]))


def test_a_surface_of_the_points_themselves_is_the_plain_correction():
    vertices, triangles = meshes.bumpy_ball(2)
    count = len(vertices)
    surface = isochor.Surface(np.arange(count + 1), np.arange(count), np.ones(count))
    plain, over = (LATTICE.bind(vertices, triangles, device="cpu", surface=s) for s in (None, surface))
    for method in ("balanced", "gradient"):
        expected, found = (binding.preserve(SQUASHED, method=method) for binding in (plain, over))
        np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-13)
        np.testing.assert_array_equal(found.surface, found.vertices)
        assert expected.surface is None


def test_rows_carry_any_values_and_wrong_ones_are_refused():
    surface = isochor.Surface([0, 1, 3], [0, 0, 1], [1.0, 0.5, 0.5])
    assert (len(surface), surface.point_count) == (2, 2)
    np.testing.assert_array_equal(surface.apply([[1.0], [3.0]]), [[1.0], [2.0]])
    np.testing.assert_array_equal(surface.offsets, [0, 1, 3])
    with pytest.warns(RuntimeWarning, match="1 rows do not sum to 1"):
        isochor.Surface([0, 1], [0], [2.0])
    for offsets, columns, weights, said in (
        ([0, 2], [0], [1.0], "offsets"),
        ([0, 1, 1], [0], [1.0], "row 1"),
        ([0, 1], [-1], [1.0], "columns"),
        ([0, 1], [0], [np.nan], "NaN"),
        ([0, 1], [0], [1.0, 2.0], "weights"),
    ):
        with refused(MeshError, said):
            isochor.Surface(offsets, columns, weights)
    with refused(MeshError, "points", 3):
        surface.apply(np.zeros((3, 3)))
    with refused(MeshError, "surface"):
        LATTICE.bind(np.zeros((3, 3)), surface=surface)
    with refused(MeshError, "surface"):
        LATTICE.bind(np.zeros((2, 3)), surface=3)


def test_wrong_patches_are_refused():
    points, indices = urn()
    for bad, said in ((indices + len(points), len(points)), (indices[:, :1], "shape"), (indices[0], "shape")):
        with refused(MeshError, said):
            isochor.Patches(points, bad)
    patches = isochor.Patches(points, indices)
    with refused(MeshError, "level"):
        patches.tessellate(0)
    with refused(MeshError, "uv"):
        patches.evaluate(0, [[0.5, 1.5]])
    with refused(MeshError, "patch", 8):
        patches.normals([8], [[0.5, 0.5]])
