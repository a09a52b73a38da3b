# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive tessellation: crack-free, in rest space, as fine as the tolerance asks and no finer than it must."""

import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from laws_bodies import edges_are_shared
from oracle import Embedded, Spec
from scipy import sparse

SPECS = {
    "bernstein": Spec((4, 4, 4)),
    "uniform": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "rational": lattices.weighted(Spec((4, 4, 4))),
    "blender": Spec((4, 4, 4), "blender"),
}
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
TOLERANCE = 2e-3


def coarse():
    return meshes.box(2, (0.1, 0.1, 0.1), (0.9, 0.9, 0.9))


def bent(spec: Spec):
    return lattices.deformed(spec, "twist", 0.5)


def refined(spec: Spec, tolerance: float = TOLERANCE, mesh=None, **options):
    vertices, triangles = coarse() if mesh is None else mesh
    return isochor.tessellate(spec.build(), vertices, triangles, bent(spec), tolerance, **options)


def rows(found, count: int):
    """The parents as a sparse matrix on the vertices given."""
    return sparse.csr_matrix(found.parents.apply(np.eye(count)))


@each_spec
def test_the_result_is_closed_and_nothing_at_rest_has_changed(spec):
    vertices, triangles = coarse()
    found = refined(spec)
    edges_are_shared(found.triangles)
    assert len(found.triangles) > len(triangles)
    np.testing.assert_array_equal(found.vertices[: len(vertices)], vertices)
    whole = oracle.volume(vertices, triangles)
    assert oracle.volume(found.vertices, found.triangles) == pytest.approx(whole, rel=1e-13)
    assert oracle.area(found.vertices, found.triangles) == pytest.approx(oracle.area(vertices, triangles), rel=1e-12)


@each_spec
def test_parents_reproduce_the_vertices(spec):
    """Each new vertex is a convex combination of the corners of one face given; so is what hangs on the vertices."""
    vertices, triangles = coarse()
    found = refined(spec)
    parents = rows(found, len(vertices))
    np.testing.assert_allclose(parents @ vertices, found.vertices, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.asarray(parents.sum(axis=1)).ravel(), 1, rtol=0, atol=1e-15)
    assert parents.data.min() >= 0
    assert found.parent_triangle.shape == (len(found.triangles),)
    for corners, parent in zip(found.triangles, found.parent_triangle):
        used = set(np.unique(parents[corners].indices[parents[corners].data > 0]).tolist())
        assert used <= set(triangles[parent].tolist())
    covered = np.bincount(found.parent_triangle, areas(found.vertices, found.triangles), minlength=len(triangles))
    np.testing.assert_allclose(covered, areas(vertices, triangles), rtol=1e-12)


def areas(vertices, triangles):
    corners = vertices[triangles]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


@each_spec
def test_the_deformed_surface_is_within_the_tolerance(spec):
    """Edges at a quarter, half and three quarters, and the faces' middles, against the deformed flat ones."""
    found = refined(spec, levels=8)
    far = deviation(spec, found.vertices, found.triangles)
    assert far <= TOLERANCE * (1 + 1e-9)
    assert deviation(spec, *coarse()) > 5 * TOLERANCE
    assert found.before == pytest.approx(deviation(spec, *coarse()), rel=1e-6)
    assert found.after == pytest.approx(far, rel=1e-6)


def deviation(spec: Spec, vertices, triangles) -> float:
    """Largest distance of deformed points on edges and of faces' middles from the straight edges and flat faces."""
    moved = deform(spec, vertices)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    middles = deform(spec, vertices[triangles].mean(axis=1))
    return float(max(from_straight(spec, vertices, moved, sides).max(), from_flat(middles, moved[triangles]).max()))


def from_straight(spec: Spec, vertices, moved, edges):
    """(E,) the farthest of the deformed points at a quarter, a half and three quarters from the deformed ends' line."""
    a, b = moved[edges[:, 0]], moved[edges[:, 1]]
    found = np.zeros(len(edges))
    for t in (0.25, 0.5, 0.75):
        points = deform(spec, (1 - t) * vertices[edges[:, 0]] + t * vertices[edges[:, 1]])
        shares = np.clip(np.sum((points - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0, 1)
        found = np.maximum(found, np.linalg.norm(points - a - shares[:, None] * (b - a), axis=1))
    return found


def from_flat(points, corners):
    """(F,) distance of points from triangles: of their planes where the foot is inside, else of the nearest side."""
    a, b, c = np.moveaxis(corners, 1, 0)
    basis = np.stack([b - a, c - a], axis=-1)
    shares = np.array([np.linalg.lstsq(m, p, rcond=None)[0] for m, p in zip(basis, points - a)])
    foot = a + np.einsum("fxk,fk->fx", basis, shares)
    inside = np.all(shares >= 0, axis=1) & (shares.sum(axis=1) <= 1)
    assert inside.all(), "these tests bend triangles by less than their size"
    return np.linalg.norm(points - foot, axis=1)


def deform(spec: Spec, points):
    return Embedded.of(spec, points, np.zeros((0, 3), int), outside="extend").deform(bent(spec))


@each_spec
def test_a_finer_tolerance_costs_more_and_a_coarse_one_nothing(spec):
    counts = [len(refined(spec, tolerance, levels=8).triangles) for tolerance in (1.0, 1e-2, 2e-3, 5e-4)]
    assert counts[0] == len(coarse()[1])
    assert counts == sorted(counts)
    assert counts[-1] > 2 * counts[1]


def test_the_flat_part_of_a_locally_bent_mesh_is_left_alone():
    """Only what is bent is split: a bump in one corner of a long board."""
    spec = Spec((12, 4, 4), "bspline", 3, "clamped", edges=((4, 0, 0), (0, 1, 0), (0, 0, 1)))
    vertices, triangles = meshes.box(6, (0.05, 0.1, 0.4), (3.95, 0.9, 0.6))
    control = spec.rest.copy()
    control[1:3, 1:3, :, 2] += 0.5
    found = isochor.tessellate(spec.build(), vertices, triangles, control, 1e-3)
    edges_are_shared(found.triangles)
    middles = found.vertices[found.triangles].mean(axis=1)[:, 0]
    old = vertices[triangles].mean(axis=1)[:, 0]
    assert np.sum(middles > 3) <= 1.5 * np.sum(old > 3)
    assert np.sum(middles < 2) > 3 * np.sum(old < 2)


def test_levels_bound_the_work():
    for levels in (0, 1, 2):
        found = refined(SPECS["bernstein"], 1e-9, levels=levels)
        assert len(found.triangles) <= len(coarse()[1]) * 4**levels
        edges_are_shared(found.triangles)


def test_affine_and_rest_need_no_splitting():
    spec = SPECS["bernstein"]
    linear, offset = lattices.affine()
    for control in (spec.rest, spec.rest @ linear.T + offset):
        found = isochor.tessellate(spec.build(), *coarse(), control, 1e-9)
        np.testing.assert_array_equal(found.triangles, coarse()[1])


def test_an_open_mesh_stays_without_cracks():
    """Only the boundary that was there is there afterwards, edge by edge."""
    vertices, triangles = meshes.opened(coarse(), 5)
    spec = SPECS["bernstein"]
    found = isochor.tessellate(spec.build(), vertices, triangles, bent(spec), TOLERANCE)
    half = np.concatenate([found.triangles[:, [0, 1]], found.triangles[:, [1, 2]], found.triangles[:, [2, 0]]])
    pairs = set(map(tuple, half.tolist()))
    assert len(pairs) == len(half)
    lone = np.array([pair for pair in pairs if pair[::-1] not in pairs])
    hole = coarse()[0][coarse()[1][5]]
    length = np.linalg.norm(np.diff(found.vertices[lone], axis=1)[:, 0], axis=1).sum()
    assert length == pytest.approx(np.linalg.norm(hole - np.roll(hole, 1, axis=0), axis=1).sum(), rel=1e-12)


def test_the_decision_alone():
    """bent_edges says which edges are farther from straight than the tolerance, by the same measure."""
    spec = SPECS["uniform"]
    vertices, triangles = meshes.bumpy_ball(2, 0.1)
    edges = np.unique(np.sort(triangles[:, [0, 1]], 1), axis=0)
    far = from_straight(spec, vertices, deform(spec, vertices), edges)
    tolerance = float(np.median(far))
    found = isochor.bent_edges(spec.build(), vertices, edges, bent(spec), tolerance)
    assert (found.dtype, found.shape) == (np.bool_, (len(edges),))
    clear = np.abs(far / tolerance - 1) > 1e-6
    np.testing.assert_array_equal(found[clear], (far > tolerance)[clear])


def test_a_mask_and_points_outside_count():
    """An influence of zero bends nothing; what lies outside and is kept is straight, and a crossing edge is not."""
    spec = SPECS["bernstein"]
    vertices, triangles = coarse()
    still = isochor.tessellate(
        spec.build(), vertices, triangles, bent(spec), TOLERANCE, influence=np.zeros(len(vertices))
    )
    assert len(still.triangles) == len(triangles)
    away = isochor.tessellate(spec.build(), vertices + 5, triangles, bent(spec), TOLERANCE, outside="keep")
    assert len(away.triangles) == len(triangles)
