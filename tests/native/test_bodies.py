# SPDX-License-Identifier: GPL-3.0-or-later
"""Many volumes at once: islands, labelled regions, and holes closed by virtual caps."""

import cases
import closings
import lattices
import meshes
import numpy as np
import oracle
import pytest
from corrections import Correction, Solid
from isochor import MeshError
from oracle import Embedded, Spec
from refusals import refused

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-6": Spec((6, 6, 6), "bspline", 2, "clamped"),
}
DTYPES = {"float64": np.float64, "float32": np.float32}
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", cases.METHODS)
each_dtype = pytest.mark.parametrize("dtype", DTYPES.values(), ids=DTYPES)


def many_islands(dtype=np.float64):
    """A ball, a box, a torus and a ball turned inside out, in one mesh."""
    mesh = meshes.joined(meshes.two_islands(), meshes.torus(12, 6, 0.12, 0.05, (0.75, 0.25, 0.3)))
    mesh = meshes.joined(mesh, meshes.inside_out(meshes.icosphere(1, 0.12, (0.3, 0.7, 0.7))))
    return mesh[0].astype(dtype), mesh[1]


def squashed(spec: Spec, seed: int = 5) -> np.ndarray:
    return spec.centre + (lattices.noisy(spec, 0.06, seed) - spec.centre) * [1.05, 0.95, 0.55]


def check_each(result, vertices, bodies, targets) -> None:
    """Every body's volume, measured on the vertices, its holes closed by fans, is its target."""
    found = closings.closed_volumes(result.vertices.astype(float), bodies)
    for k, body in enumerate(bodies):
        room = oracle.tolerance(result.vertices, body, (0.5, 0.5, 0.5), targets[k])
        assert abs(found[k] - targets[k]) <= room * abs(targets[k]), f"body {k}: {found[k]}, not {targets[k]}"
    np.testing.assert_allclose(result.targets, targets, rtol=1e-12 if vertices.dtype == np.float64 else 1e-6)
    np.testing.assert_allclose(result.volumes, found, rtol=1e-11 if vertices.dtype == np.float64 else 1e-5)
    assert result.volume == pytest.approx(result.volumes.sum(), rel=1e-12)
    assert result.target == pytest.approx(result.targets.sum(), rel=1e-12)
    errors = np.abs(result.volumes - result.targets) / np.abs(result.targets)
    assert result.error == pytest.approx(errors.max(), abs=1e-15)


def in_its_order(binding, triangles, bodies) -> list:
    """The bodies in the order in which the binding counts them."""
    labels = binding.body_of_triangle
    assert labels.dtype == np.int32
    assert labels.shape == (len(triangles),)
    of_triangle = {tuple(t): k for t, k in zip(triangles.tolist(), labels.tolist())}
    ordered = sorted(bodies, key=lambda body: of_triangle[tuple(body[0].tolist())])
    for k, body in enumerate(ordered):
        assert {of_triangle[tuple(t)] for t in body.tolist()} == {k}
    return ordered


@each_spec
@each_method
@each_dtype
def test_every_island_keeps_its_own_volume(spec, method, dtype):
    vertices, triangles = many_islands(dtype)
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    assert binding.body_count == 4
    bodies = in_its_order(binding, triangles, closings.islands(triangles))
    rest = closings.closed_volumes(vertices.astype(float), bodies)
    np.testing.assert_allclose(binding.reference_volumes, rest, rtol=1e-12 if dtype == np.float64 else 1e-6)
    assert binding.reference_volume == pytest.approx(binding.reference_volumes.sum(), rel=1e-12)
    control = squashed(spec)
    volumes = closings.closed_volumes(binding.deform(control).astype(float), bodies)
    np.testing.assert_allclose(binding.volumes(control), volumes, rtol=1e-12 if dtype == np.float64 else 1e-5)
    result = binding.preserve(control, method=method)
    check_each(result, vertices, bodies, rest)


@each_spec
@pytest.mark.parametrize("method", ["sweep", "balanced"])
def test_islands_are_the_closed_form_with_a_row_each(spec, method):
    vertices, triangles = many_islands()
    embedded, control = Embedded.of(spec, vertices, triangles), squashed(spec)
    chosen = [4, 100]
    moves = np.array([[0.05, 0.02, -0.03], [-0.02, 0.04, 0.01]])
    asked = Correction(
        Solid.of(embedded, closings.islands(triangles)), control, pin_rows=embedded.rows[chosen], pin_moves=moves
    )
    pins = (chosen, embedded.deform(control)[chosen] + moves)
    result = spec.build().bind(vertices, triangles, bodies="islands").preserve(control, method=method, pins=pins)
    expected = getattr(asked, method)()
    assert result.method == method
    assert np.linalg.norm(result.control - expected) <= 1e-9 * np.linalg.norm(expected - control)


@each_spec
def test_nearest_with_islands_pins_and_weights_is_a_kkt_point_and_the_shortest(spec):
    vertices, triangles = many_islands()
    embedded, control = Embedded.of(spec, vertices, triangles), squashed(spec)
    weights = np.exp(np.random.default_rng(1).uniform(0, 3, spec.shape))
    moves = np.array([[0.05, 0.02, -0.03]])
    asked = Correction(
        Solid.of(embedded, closings.islands(triangles)),
        control,
        weights=weights,
        pin_rows=embedded.rows[[4]],
        pin_moves=moves,
    )
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    pins = ([4], embedded.deform(control)[[4]] + moves)
    results = {m: binding.preserve(control, method=m, weights=weights, pins=pins) for m in cases.METHODS}
    assert asked.stationarity(results["nearest"].control) <= 1e-7
    lengths = {m: asked.distance(result.control) for m, result in results.items()}
    assert lengths["nearest"] <= min(lengths.values()) * (1 + 1e-9)


@each_method
@each_dtype
def test_a_tiny_island_beside_a_huge_one(method, dtype):
    spec = SPECS["uniform-6"]
    vertices, triangles = meshes.tiny_beside_huge()
    vertices = vertices.astype(dtype)
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    bodies = in_its_order(binding, triangles, closings.islands(triangles))
    result = binding.preserve(squashed(spec), method=method)
    check_each(result, vertices, bodies, closings.closed_volumes(vertices.astype(float), bodies))
    assert np.abs(result.control - squashed(spec)).max() < 5


@each_method
def test_without_bodies_only_the_sum_is_kept(method):
    spec, (vertices, triangles) = SPECS["bernstein-4"], meshes.two_islands()
    binding = spec.build().bind(vertices, triangles)
    assert binding.body_count == 1
    np.testing.assert_array_equal(binding.body_of_triangle, 0)
    result = binding.preserve(squashed(spec), method=method)
    assert oracle.volume(result.vertices, triangles) == pytest.approx(oracle.volume(vertices, triangles), rel=1e-12)
    parts = closings.closed_volumes(result.vertices, closings.islands(triangles))
    assert np.abs(parts / closings.closed_volumes(vertices, closings.islands(triangles)) - 1).min() > 1e-4


@each_method
def test_each_body_has_a_target_of_its_own_and_one_number_is_shared_in_proportion(method):
    spec, (vertices, triangles) = SPECS["uniform-6"], meshes.two_islands()
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    bodies = in_its_order(binding, triangles, closings.islands(triangles))
    rest, control = binding.reference_volumes, squashed(spec)
    wanted = rest * [1.2, 0.7]
    check_each(binding.preserve(control, method=method, target=wanted), vertices, bodies, wanted)
    shared = binding.preserve(control, method=method, target=float(rest.sum() * 1.3))
    check_each(shared, vertices, bodies, rest * 1.3)


@each_method
def test_amount_weakens_every_bodys_own_change(method):
    spec, (vertices, triangles) = SPECS["uniform-6"], meshes.two_islands()
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    bodies = in_its_order(binding, triangles, closings.islands(triangles))
    control = squashed(spec)
    before, rest = binding.volumes(control), binding.reference_volumes
    for amount in (0.0, 0.5):
        result = binding.preserve(control, method=method, amount=amount)
        check_each(result, vertices, bodies, before + amount * (rest - before))


@each_spec
@each_method
@each_dtype
def test_regions_share_their_border_and_each_keeps_its_volume(spec, method, dtype):
    """Two labelled halves of one ball, closed by fans about their common border's mean, add up to the ball."""
    vertices, triangles = meshes.bumpy_ball(2, 0.2)
    vertices = vertices.astype(dtype)
    labels = (vertices[triangles].mean(axis=1)[:, 0] > 0.55).astype(int)
    binding = spec.build().bind(vertices, triangles, bodies=labels)
    np.testing.assert_array_equal(binding.body_of_triangle, labels)
    bodies = closings.regions(triangles, labels)
    rest = closings.closed_volumes(vertices.astype(float), bodies)
    result = binding.preserve(squashed(spec), method=method)
    check_each(result, vertices, bodies, rest)
    whole = oracle.volume(vertices, triangles)
    assert oracle.volume(result.vertices, triangles) == pytest.approx(whole, rel=2e-12 if dtype == np.float64 else 2e-6)
    inflated = binding.preserve(squashed(spec), method=method, target=rest * [1, 1.3])
    check_each(inflated, vertices, bodies, rest * [1, 1.3])


@each_method
def test_triangles_without_a_body_just_deform_along(method):
    spec, (vertices, triangles) = SPECS["bernstein-4"], meshes.two_islands()
    labels = np.where(triangles[:, 0] < len(meshes.icosphere(2)[0]), -1, 0)
    binding = spec.build().bind(vertices, triangles, bodies=labels)
    assert binding.body_count == 1
    result = binding.preserve(squashed(spec), method=method)
    bodies = closings.regions(triangles, labels)
    check_each(result, vertices, bodies, closings.closed_volumes(vertices, bodies))
    alone = spec.build().bind(vertices, triangles[labels == 0]).preserve(squashed(spec), method=method)
    np.testing.assert_allclose(result.control, alone.control, rtol=0, atol=1e-9)


def open_ball(holes: int):
    """A ball without the triangles around some vertices: a loop of five or six edges at each."""
    vertices, triangles = meshes.bumpy_ball(2, 0.1)
    for apex in (0, 3, 9)[:holes]:
        triangles = triangles[~(triangles == apex).any(axis=1)]
    return vertices, triangles


@each_spec
@each_method
@each_dtype
@pytest.mark.parametrize("holes", [1, 3])
def test_holes_closed_by_caps(spec, method, dtype, holes):
    vertices, triangles = open_ball(holes)
    vertices = vertices.astype(dtype)
    binding = spec.build().bind(vertices, triangles, caps=True)
    rest = closings.closed_volumes(vertices.astype(float), [triangles])
    np.testing.assert_allclose(binding.reference_volumes, rest, rtol=1e-12 if dtype == np.float64 else 1e-6)
    result = binding.preserve(squashed(spec), method=method)
    check_each(result, vertices, [triangles], rest)


@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient"])
def test_caps_are_part_of_the_closed_form(method):
    spec, (vertices, triangles) = SPECS["uniform-6"], open_ball(3)
    control = squashed(spec)
    asked = Correction(Solid.of(Embedded.of(spec, vertices, triangles)), control)
    result = spec.build().bind(vertices, triangles, caps=True).preserve(control, method=method)
    expected = getattr(asked, method)()
    assert np.linalg.norm(result.control - expected) <= 1e-9 * np.linalg.norm(expected - control)


@each_method
def test_a_cup_a_closed_box_and_pins_together(method):
    """An open piece closed by a cap, a closed one, a pin on each, weights and two axes only."""
    ball = open_ball(1)
    small = (ball[0] - 0.5) * 0.5 + [0.3, 0.3, 0.4], ball[1]
    vertices, triangles = meshes.joined(small, meshes.box(3, (0.6, 0.55, 0.45), (0.95, 0.9, 0.95)))
    spec = SPECS["uniform-6"]
    binding = spec.build().bind(vertices, triangles, bodies="islands", caps=True)
    assert binding.body_count == 2
    bodies = in_its_order(binding, triangles, closings.islands(triangles))
    control = squashed(spec)
    chosen = [20, len(vertices) - 1]
    places = binding.deform(control)[chosen] + [[0.03, 0, 0.01], [-0.02, 0.02, 0]]
    weights = np.exp(np.random.default_rng(3).uniform(0, 2, spec.shape))
    result = binding.preserve(control, method=method, axes=(1, 1, 0), weights=weights, pins=(chosen, places))
    check_each(result, vertices, bodies, closings.closed_volumes(vertices, bodies))
    np.testing.assert_allclose(result.vertices[chosen], places, rtol=0, atol=1e-12)


def test_a_hole_without_caps_is_refused_and_found():
    vertices, triangles = open_ball(3)
    binding = SPECS["bernstein-4"].build().bind(vertices, triangles)
    edges = sum(len(loop) for loop in closings.loops(triangles))
    with refused(MeshError, "hole", 3, (edges, *(len(loop) for loop in closings.loops(triangles)))):
        binding.preserve(SPECS["bernstein-4"].rest)


def test_caps_change_nothing_of_a_closed_mesh():
    spec, mesh = SPECS["bernstein-4"], meshes.bumpy_ball(2)
    one, other = (spec.build().bind(*mesh, caps=caps) for caps in (False, True))
    assert other.reference_volume == pytest.approx(one.reference_volume, rel=1e-14)
    results = [binding.preserve(squashed(spec)).control for binding in (one, other)]
    np.testing.assert_allclose(results[1], results[0], rtol=0, atol=1e-13)


def test_open_and_flat_pieces_have_no_volume_and_deform_along():
    vertices, triangles = meshes.joined(meshes.two_islands(), meshes.opened(meshes.icosphere(1, 0.05, (0.8, 0.2, 0.2))))
    flat = meshes.flat()
    vertices, triangles = meshes.joined((vertices, triangles), (flat[0] * 0.2 + [0.1, 0.7, 0.1], flat[1]))
    spec = SPECS["uniform-6"]
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    assert binding.body_count == 2
    assert np.count_nonzero(binding.body_of_triangle == -1) == 79 + len(flat[1])
    result = binding.preserve(squashed(spec))
    bodies = in_its_order(binding, triangles, closings.islands(triangles)[:2])
    check_each(result, vertices, bodies, closings.closed_volumes(vertices, bodies))
    np.testing.assert_allclose(result.vertices, binding.deform(result.control), rtol=0, atol=1e-13)


@each_dtype
def test_update_keeps_the_bodies(dtype):
    spec = SPECS["uniform-6"]
    vertices, triangles = many_islands(dtype)
    moved = (vertices * [0.9, 1.0, 0.95]).astype(dtype)
    binding = spec.build().bind(vertices, triangles, bodies="islands")
    binding.update(moved)
    fresh = spec.build().bind(moved, triangles, bodies="islands")
    np.testing.assert_allclose(binding.reference_volumes, fresh.reference_volumes, rtol=1e-12)
    control = squashed(spec)
    for method in cases.METHODS:
        one, other = (b.preserve(control, method=method).control for b in (binding, fresh))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 if dtype == np.float64 else 1e-4)
