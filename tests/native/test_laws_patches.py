# SPDX-License-Identifier: GPL-3.0-or-later
"""Bézier patches: what they are, how they are tessellated, and how the tessellation comes to the true body."""

import isochor
import lattices
import laws_exact as exact
import meshes
import numpy as np
import oracle
import pytest
from laws_bodies import Body, edges_are_shared, lemon, lidded, torus
from laws_papers import eval_surface, pt_on_surface
from oracle import Spec
from scipy import sparse

BODIES = {"cube": lidded(4), "quadratic": lidded(3), "high": lidded(6), "torus": torus(), "lemon": lemon()}
each_body = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
LEVELS = (2, 3, 5)  # of one segment the lemon would be a line


def made(body: Body) -> isochor.Patches:
    return isochor.Patches(body.points, body.patches)


def places(count: int = 25, seed: int = 1):
    uv = np.random.default_rng(seed).random((count, 2))
    uv[:4] = [[0, 0], [1, 0], [0, 1], [1, 1]]
    return uv


def test_the_bodies_of_these_tests_are_what_they_seem():
    assert lidded(4, 0.0).volume() == pytest.approx(0.7**3, rel=1e-14)
    assert torus().volume() == pytest.approx(2 * np.pi**2 * 0.28 * 0.12**2, rel=1e-3)
    assert all(body.volume() > 0 for body in BODIES.values())


@each_body
def test_a_patch_is_de_casteljau_and_ferriers_listing(body):
    patches, uv = made(body), places()
    for number, indices in enumerate(body.patches):
        net = body.points[indices]
        found = patches.evaluate(number, uv)
        assert found.shape == (len(uv), 3)
        expected = np.array([pt_on_surface(u, v, net) for u, v in uv])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
        if net.shape == (4, 4, 3):
            np.testing.assert_allclose(found, [eval_surface(net, u, v) for u, v in uv], rtol=0, atol=1e-14)


def test_degrees_differ_along_the_two_sides_and_go_past_twenty():
    points = np.random.default_rng(2).uniform(-1, 1, (26 * 3, 3))
    patches = isochor.Patches(points, np.arange(26 * 3).reshape(1, 26, 3))
    uv = places(6)
    spec = Spec((26, 3, 1))
    expected = exact.blends(spec, np.pad(uv, ((0, 0), (0, 1))), points.reshape(26, 3, 1, 3))
    np.testing.assert_allclose(patches.evaluate(0, uv), expected, rtol=0, atol=8 * 2.3e-16)


def test_a_face_of_a_lattice_is_a_patch_of_its_layer():
    """Deforming the shell of a block as patches, or as the block's face, is the same surface."""
    spec = Spec((4, 5, 3))
    control = lattices.noisy(spec, 0.4)
    patches = isochor.Patches(control.reshape(-1, 3), np.arange(60).reshape(4, 5, 3)[:, :, -1][None])
    uv = places()
    on_face = np.column_stack([uv, np.ones(len(uv))])
    np.testing.assert_allclose(patches.evaluate(0, uv), spec.build().evaluate(on_face, control), rtol=0, atol=1e-14)


@each_body
def test_normals_are_unit_and_perpendicular_and_point_out(body):
    patches, uv = made(body), np.random.default_rng(3).uniform(0.05, 0.95, (20, 2))
    step = 1e-5
    for number in range(len(body.patches)):
        normals = patches.normals(number, uv)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=0, atol=1e-12)
        slopes = [
            (patches.evaluate(number, uv + move) - patches.evaluate(number, uv - move)) / (2 * step)
            for move in step * np.eye(2)
        ]
        out = np.cross(*slopes)
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        np.testing.assert_allclose(normals, out, rtol=0, atol=1e-7)


@each_body
@pytest.mark.parametrize("level", LEVELS)
def test_a_closed_model_gives_a_closed_mesh_at_every_level(body, level):
    tessellation = made(body).tessellate(level)
    vertices = tessellation.surface.apply(body.points)
    edges_are_shared(tessellation.triangles)
    assert tessellation.triangles.min() == 0
    assert tessellation.triangles.max() == len(vertices) - 1
    assert set(tessellation.triangles.ravel().tolist()) == set(range(len(vertices))), "a vertex that no face uses"
    corners = vertices[tessellation.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert areas.min() > 1e-9, "a face without area"
    assert len(np.unique(np.round(vertices, 10), axis=0)) == len(vertices), "one place, two vertices"
    assert oracle.volume(vertices, tessellation.triangles, (0.5, 0.5, 0.5)) > 0


@each_body
@pytest.mark.parametrize("level", LEVELS)
def test_every_vertex_lies_where_its_parameters_say(body, level):
    tessellation = made(body).tessellate(level)
    vertices = tessellation.surface.apply(body.points)
    assert tessellation.parameters.shape == (len(vertices), 2)
    for number in range(len(body.patches)):
        mine = tessellation.patch_of_vertex == number
        expected = [pt_on_surface(u, v, body.points[body.patches[number]]) for u, v in tessellation.parameters[mine]]
        if mine.any():
            np.testing.assert_allclose(vertices[mine], expected, rtol=0, atol=1e-14)


@each_body
def test_the_rows_are_affine_and_follow_any_motion_of_the_points(body):
    """Partition of unity: an affine motion of the control points is that motion of the tessellation."""
    tessellation = made(body).tessellate(3)
    linear, offset = lattices.affine()
    moved = tessellation.surface.apply(body.points @ linear.T + offset)
    np.testing.assert_allclose(moved, tessellation.surface.apply(body.points) @ linear.T + offset, rtol=0, atol=1e-14)
    other = body.points + np.random.default_rng(5).uniform(-0.02, 0.02, body.points.shape)
    again = isochor.Patches(other, body.patches).tessellate(3)
    np.testing.assert_array_equal(again.triangles, tessellation.triangles)
    np.testing.assert_allclose(tessellation.surface.apply(other), again.surface.apply(other), rtol=0, atol=1e-15)


@each_body
def test_the_volume_converges_to_the_body_s(body):
    """Gauss' quadrature is exact for polynomial patches; flat triangles come to it with the square of their size."""
    true, volumes = body.volume(), []
    for level in (8, 16, 32):
        tessellation = made(body).tessellate(level)
        volumes.append(oracle.volume(tessellation.surface.apply(body.points), tessellation.triangles, (0.5, 0.5, 0.5)))
    errors = np.abs(np.array(volumes) / true - 1)
    assert errors[2] < errors[1] / 2.5 < errors[0] / 2.5**2
    assert (4 * volumes[2] - volumes[1]) / 3 == pytest.approx(true, rel=3e-5)


def test_quads_are_the_triangles_in_pairs():
    tessellation = made(BODIES["torus"]).tessellate(3)
    quads = np.asarray(tessellation.quads)
    assert quads.shape[1] == 4
    assert 2 * len(quads) == len(tessellation.triangles)
    halves = {frozenset(t) for t in tessellation.triangles.tolist()}
    for a, b, c, d in quads.tolist():
        assert ({frozenset((a, b, c)), frozenset((a, c, d))} <= halves) or (
            {frozenset((a, b, d)), frozenset((b, c, d))} <= halves
        )


def test_a_surface_applies_its_rows():
    """Rows as given, repeated columns too, to whatever points have: scipy's sparse product."""
    random = np.random.default_rng(4)
    offsets, columns = [0, 3, 5, 6], [0, 2, 4, 1, 1, 3]
    weights = np.array([0.2, 0.5, 0.3, 0.4, 0.6, 1.0])
    surface = isochor.Surface(offsets, columns, weights, point_count=5)
    matrix = sparse.csr_matrix((weights, columns, offsets), shape=(3, 5))
    for points in (random.normal(size=(5, 3)), random.normal(size=(5, 1)), random.normal(size=(5, 7))):
        np.testing.assert_allclose(surface.apply(points), matrix @ points, rtol=0, atol=1e-15)
    with pytest.warns(RuntimeWarning, match="1"):
        isochor.Surface([0, 1], [0], [0.5])


def test_a_surface_of_single_points_is_the_mesh_itself():
    """Identity rows: the same volume and the same correction as without a surface."""
    spec = Spec((4, 4, 4))
    vertices, triangles = meshes.bumpy_ball(2, 0.2)
    count = len(vertices)
    surface = isochor.Surface(np.arange(count + 1), np.arange(count), np.ones(count))
    control = lattices.deformed(spec, "squash", 0.5)
    plain = spec.build().bind(vertices, triangles, device="cpu").preserve(control)
    through = spec.build().bind(vertices, triangles, surface=surface, device="cpu").preserve(control)
    np.testing.assert_allclose(through.control, plain.control, rtol=0, atol=1e-12)
    np.testing.assert_allclose(through.surface, plain.vertices, rtol=0, atol=1e-12)


@each_body
def test_patches_given_the_wrong_way_round_are_turned(body):
    """Every second patch transposed or run backwards: the mesh is closed, wound as one, and as large."""
    turned = [net.T if k % 4 == 1 else net[::-1] if k % 4 == 3 else net for k, net in enumerate(body.patches)]
    tessellation = isochor.Patches(body.points, np.array(turned)).tessellate(4)
    straight = made(body).tessellate(4)
    edges_are_shared(tessellation.triangles)
    volumes = [
        oracle.volume(t.surface.apply(body.points), t.triangles, (0.5, 0.5, 0.5)) for t in (tessellation, straight)
    ]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-2)
    assert volumes[0] > 0


def test_an_open_patch_has_its_four_edges_for_a_border():
    net = np.random.default_rng(6).random((20, 3))
    tessellation = isochor.Patches(net, np.arange(20).reshape(1, 4, 5)).tessellate(6)
    half = tessellation.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()
    lone = [pair for pair in map(tuple, half) if pair[::-1] not in set(map(tuple, half))]
    assert len(lone) == 4 * 6
    border = tessellation.parameters[np.unique(lone)]
    assert np.all(np.any((border == 0) | (border == 1), axis=1))


def test_patches_that_only_touch_in_space_are_not_joined():
    """Sharing is by control points, not by places: two patches side by side with points of their own stay apart."""
    one = np.stack(np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4), [0.0], indexing="ij"), axis=-1).reshape(
        -1, 3
    )
    points = np.concatenate([one, one + [1, 0, 0]])
    apart = isochor.Patches(points, np.arange(32).reshape(2, 4, 4)).tessellate(3)
    assert len(apart.patch_of_vertex) == 2 * 16
    shared = np.arange(32).reshape(2, 4, 4)
    shared[1, 0] = shared[0, 3]
    assert len(isochor.Patches(points, shared).tessellate(3).patch_of_vertex) == 2 * 16 - 4
