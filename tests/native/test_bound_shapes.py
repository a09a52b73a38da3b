# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice that is shaped first and bound then: the way back through it, and meshes embedded in that shape."""

from concurrent.futures import ThreadPoolExecutor

import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from lattices import BERNSTEIN, BSPLINE, FRAMES, THIN
from oracle import Spec
from promised import SHARES, SPECS
from refusals import refused

EVERY = {**BERNSTEIN, **BSPLINE, **FRAMES}
each_spec = pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
each_promised = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])


def shaped(spec: Spec, seed: int = 5):
    """Control points at random, by so little that the lattice folds nowhere, then rotated and stretched a little."""
    amount = 0.3 / max(spec.shape)
    linear, offset = lattices.affine(seed)
    return (lattices.noisy(spec, amount, seed) - spec.centre) @ linear.T + spec.centre + offset * 0.1


def determinants(spec: Spec, parameters, control):
    """Of the map's derivative, by central differences in parameters."""
    step = 1e-6
    columns = [
        (spec.matrix(parameters + step * unit) - spec.matrix(parameters - step * unit)) @ control.reshape(-1, 3)
        for unit in np.eye(3)
    ]
    return np.linalg.det(np.stack(columns, axis=-1) / (2 * step))


@each_spec
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_inverting_what_was_evaluated_gives_the_parameters(spec, seed):
    control = shaped(spec, seed)
    parameters = np.random.default_rng(seed).uniform(1e-3, 1 - 1e-3, (300, 3))
    signs = np.sign(determinants(spec, parameters, control))
    assert np.all(signs == signs[0]), "the lattice must not fold for this law to hold"
    found, inside = spec.build().invert(spec.matrix(parameters) @ control.reshape(-1, 3), control)
    assert (found.dtype, inside.dtype) == (np.float64, np.bool_)
    assert inside.all()
    # points that are themselves rounded, over the shortest edge: what a needle's shape leaves of the digits
    atol = max(1e-12, 200 * 2.3e-16 * np.abs(control).max() / np.linalg.norm(spec.edges, axis=1).min())
    np.testing.assert_allclose(found, parameters, rtol=0, atol=atol)


@each_spec
def test_corners_faces_and_control_points_at_rest_are_inside(spec):
    points = lattices.points_inside(spec)
    found, inside = spec.build().invert(points, spec.build().rest)
    assert inside.all()
    np.testing.assert_allclose(found, spec.parameters(points), rtol=0, atol=1e-9)


@pytest.mark.parametrize("spec", THIN.values(), ids=THIN)
def test_axes_with_one_control_point_have_no_end(spec):
    lattice = spec.build()
    control = lattice.rest + np.random.default_rng(3).uniform(-0.05, 0.05, lattice.rest.shape)
    parameters = np.random.default_rng(4).uniform(0.01, 0.99, (200, 3))
    single = np.array(spec.shape) == 1
    parameters[:, single] = 30 * parameters[:, single] - 15
    found, inside = lattice.invert(lattice.evaluate(parameters, control), control)
    assert inside.all()
    np.testing.assert_allclose(found, parameters, rtol=0, atol=1e-11)


def test_every_part_of_a_lattice_bent_most_of_the_way_round_is_found():
    spec = Spec((14, 4, 4), "bspline", 3, "clamped", (0, -0.1, -0.1), ((2, 0, 0), (0, 0.2, 0), (0, 0, 0.2)))
    angle = 5.5 * spec.rest[..., 0] / 2
    radius = 2 / 5.5 - spec.rest[..., 2]
    control = np.stack([radius * np.sin(angle), spec.rest[..., 1], -radius * np.cos(angle)], axis=-1)
    parameters = np.random.default_rng(2).uniform(0, 1, (3000, 3))
    points = spec.matrix(parameters) @ control.reshape(-1, 3)
    found, inside = spec.build().invert(points, control)
    assert inside.all()
    np.testing.assert_allclose(spec.matrix(np.clip(found, 0, 1)) @ control.reshape(-1, 3), points, rtol=0, atol=1e-9)


def test_a_point_outside_gets_the_nearest_place():
    spec = Spec((4, 4, 4))
    control = shaped(spec)
    points = np.random.default_rng(1).normal(size=(100, 3))
    points = spec.centre + 3 * points / np.linalg.norm(points, axis=1, keepdims=True)
    found, inside = spec.build().invert(points, control)
    assert not inside.any()
    assert np.all((found >= 0) & (found <= 1))
    there = spec.matrix(np.random.default_rng(3).uniform(0, 1, (20_000, 3))) @ control.reshape(-1, 3)
    nearest = np.linalg.norm(points[:, None] - there[None], axis=-1).min(axis=1)
    distance = np.linalg.norm(spec.matrix(found) @ control.reshape(-1, 3) - points, axis=1)
    assert np.all(distance <= nearest + 1e-9)


def test_a_point_s_answer_depends_on_nothing_but_itself():
    spec = EVERY["bspline-3-uniform"]
    lattice, control = spec.build(), shaped(spec)
    points = lattices.points_inside(spec, count=5000)
    whole, inside = lattice.invert(points, control)
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda part: lattice.invert(part, control), np.array_split(points[::-1], 7)))
    np.testing.assert_array_equal(np.concatenate([part[0] for part in parts])[::-1], whole)
    np.testing.assert_array_equal(np.concatenate([part[1] for part in parts])[::-1], inside)


@each_spec
@each_dtype
@pytest.mark.parametrize("outside", ["keep", "extend"])
def test_the_bound_shape_is_the_identity_to_the_bit(spec, dtype, outside):
    points, rest = lattices.points_inside(spec, dtype), shaped(spec)
    binding = spec.build().bind(points, outside=outside, rest=rest, device="cpu")
    np.testing.assert_array_equal(binding.deform(rest), points)
    np.testing.assert_array_equal(binding.rest, rest)


@each_spec
@each_dtype
def test_affine_motion_of_the_bound_shape_is_that_motion_of_the_mesh(spec, dtype):
    if spec is FRAMES["needle"] and dtype == np.float32:
        return  # float32 coordinates along it are coarser than it is thick
    rest = shaped(spec)
    parameters = np.random.default_rng(6).uniform(0.02, 0.98, (300, 3))
    points = (spec.matrix(parameters) @ rest.reshape(-1, 3)).astype(dtype)
    binding = spec.build().bind(points, rest=rest, device="cpu")
    assert binding.outside_count == 0
    linear, offset = lattices.affine(21)
    control = rest @ linear.T + offset
    reach = max(np.abs(control).max(), np.abs(rest).max())
    atol = 40 * spec.rounding(reach, float(np.finfo(dtype).eps))
    np.testing.assert_allclose(binding.deform(control), points.astype(float) @ linear.T + offset, rtol=0, atol=atol)


@each_promised
@pytest.mark.parametrize("shares", SHARES, ids=str)
@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
def test_the_volume_is_kept_from_the_bound_shape_on(spec, shares, dtype):
    vertices, triangles = meshes.bumpy_ball(3, 0.15)
    rest = lattices.noisy(spec, 0.4 / max(spec.shape))
    binding = spec.build().bind(vertices.astype(dtype), triangles, rest=rest, device="cpu")
    assert binding.outside_count == 0
    whole = oracle.volume(vertices.astype(dtype), triangles, spec.centre)
    assert binding.reference_volume == pytest.approx(whole, rel=1e-12)
    control = (rest - spec.centre) * (1.1, 1.0, 0.4) + spec.centre
    lost = oracle.volume(binding.deform(control), triangles, spec.centre)
    assert lost == pytest.approx(0.44 * whole, rel=1e-5)
    result = binding.preserve(control, axes=shares)
    found = oracle.volume(result.vertices, triangles, spec.centre)
    assert abs(found / whole - 1) <= oracle.tolerance(result.vertices, triangles, spec.centre, whole)
    assert result.error <= oracle.tolerance(result.vertices, triangles, spec.centre, whole)
    again = binding.deform(result.control)
    np.testing.assert_allclose(again, result.vertices, rtol=0, atol=2e-6 if dtype == np.float32 else 1e-13)


def test_influence_scales_the_motion_from_the_bound_shape():
    spec, rest = Spec(), shaped(Spec())
    points = spec.matrix(np.random.default_rng(6).uniform(0.1, 0.9, (50, 3))) @ rest.reshape(-1, 3)
    influence = np.linspace(0, 1, 50)
    whole = spec.build().bind(points, rest=rest).deform(rest * 0.5 + 1)
    part = spec.build().bind(points, rest=rest, influence=influence).deform(rest * 0.5 + 1)
    np.testing.assert_allclose(part, points + influence[:, None] * (whole - points), rtol=0, atol=1e-14)


def test_vertices_nowhere_in_the_shape_stay_or_follow_the_nearest():
    spec, rest = Spec(), shaped(Spec())
    points = spec.centre + np.random.default_rng(9).uniform(-1.5, 1.5, (400, 3))
    parameters, inside = spec.build().invert(points, rest)
    assert 10 < inside.sum() < 390
    control = lattices.noisy(spec, 0.5, 8) + 1.0
    keep, extend = (spec.build().bind(points, rest=rest, outside=word) for word in ("keep", "extend"))
    assert keep.outside_count == extend.outside_count == (~inside).sum()
    np.testing.assert_array_equal(keep.deform(control)[~inside], points[~inside])
    moved = points + spec.matrix(np.clip(parameters, 0, 1)) @ (control - rest).reshape(-1, 3)
    np.testing.assert_allclose(extend.deform(control), moved, rtol=0, atol=1e-12)
    np.testing.assert_allclose(keep.deform(control)[inside], moved[inside], rtol=0, atol=1e-12)


def test_update_embeds_anew_what_changed():
    vertices, triangles = meshes.bumpy_ball(3)
    spec, finer = Spec(), Spec((6, 6, 6), "bspline", 3, "uniform")
    binding = spec.build().bind(vertices, triangles, rest=lattices.noisy(spec, 0.1))
    moved = vertices * (0.9, 1.0, 0.95)
    rest, control = lattices.noisy(finer, 0.05), lattices.noisy(finer, 0.2, 8)
    binding.update(vertices=moved, lattice=finer.build(), rest=rest)
    anew = finer.build().bind(moved, triangles, rest=rest)
    np.testing.assert_array_equal(binding.deform(control), anew.deform(control))
    assert binding.reference_volume == anew.reference_volume
    binding.update(influence=np.full(len(vertices), 0.5))
    np.testing.assert_allclose(binding.deform(control) - moved, (anew.deform(control) - moved) / 2, atol=1e-14)


def test_a_lattice_of_another_shape_needs_another_rest():
    spec, finer = Spec(), Spec((5, 4, 4))
    points = lattices.points_inside(spec)
    binding = spec.build().bind(points, rest=spec.rest)
    with refused(isochor.LatticeError, "rest", 64, 80):
        binding.update(lattice=finer.build())
    np.testing.assert_array_equal(binding.deform(spec.rest), points)


@pytest.mark.parametrize(
    "rest", [np.zeros((4, 4, 3, 3)), np.zeros((4, 4, 4)), np.full((4, 4, 4, 3), np.nan), "rest", 3, np.zeros((4,) * 4)]
)
def test_wrong_control_points_at_rest_are_refused(rest):
    lattice, points = Spec().build(), np.full((1, 3), 0.5)
    with refused(isochor.LatticeError, "rest"):
        lattice.bind(points, rest=rest)
    binding = lattice.bind(points)
    with refused(isochor.LatticeError, "rest"):
        binding.update(rest=rest)
    with refused(isochor.LatticeError, "control"):
        lattice.invert(points, rest)


@pytest.mark.parametrize("points", [np.full((2, 3), np.nan), np.zeros((2, 2)), "points", np.full((1, 3), np.inf)])
def test_wrong_points_are_refused(points):
    with refused(isochor.MeshError, "points"):
        Spec().build().invert(points, Spec().rest)


def test_degenerate_shapes_hold_nothing_and_break_nothing():
    vertices, triangles = meshes.bumpy_ball(2)
    flat = Spec().rest * (1, 1, 0)
    for rest in (flat, np.zeros((4, 4, 4, 3)), np.full((4, 4, 4, 3), 1e200), Spec().rest * 1e-300):
        binding = Spec().build().bind(vertices, triangles, rest=rest)
        assert binding.outside_count == len(vertices)
        np.testing.assert_array_equal(binding.deform(Spec().rest), vertices)
    assert Spec().build().invert(np.zeros((0, 3)), Spec().rest)[0].shape == (0, 3)


def test_what_is_held_is_what_deforms():
    """The frozen layers of a joint are at rest in `held`, and deforming by it is deforming by what was asked for."""
    lattice = isochor.Lattice(shape=(6, 4, 4))
    random = np.random.default_rng(3)
    points = random.random((80, 3)) * (1.5, 1, 1)
    control = lattice.rest + random.normal(0, 0.1, lattice.rest.shape)
    joined = lattice.bind(points, continuity=1)
    held = joined.held(control)
    frozen = lattice.frozen(1, ("s1",))
    np.testing.assert_array_equal(held[frozen], lattice.rest[frozen])
    np.testing.assert_array_equal(held[~frozen], control[~frozen])
    np.testing.assert_array_equal(joined.deform(control), joined.deform(held))
    np.testing.assert_array_equal(lattice.bind(points).held(control), control)
