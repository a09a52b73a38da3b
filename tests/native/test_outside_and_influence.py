# SPDX-License-Identifier: GPL-3.0-or-later
"""Points outside the domain, strength per vertex, and update of the incoming positions."""

import lattices
import meshes
import numpy as np
import pytest
from oracle import Embedded, Spec

SPECS = {
    "bernstein": Spec((4, 5, 3)),
    "uniform": Spec((6, 5, 7), "bspline", 3, "uniform"),
    "clamped": Spec((6, 5, 7), "bspline", 2, "clamped"),
    "oblique": lattices.FRAMES["oblique"],
}
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
NO_TRIANGLES = np.zeros((0, 3), int)


def scattered(spec: Spec, dtype=np.float64):
    """Points in and around the domain, none within 1e-3 of a face."""
    unit = np.random.default_rng(8).uniform(-0.6, 1.6, (400, 3))
    clear = np.all((np.abs(unit) > 1e-3) & (np.abs(unit - 1) > 1e-3), axis=1)
    return lattices.fitted(spec, unit[clear]).astype(dtype), unit[clear]


@each_spec
@each_dtype
def test_keep_does_not_move_what_is_outside(spec, dtype):
    points, unit = scattered(spec, dtype)
    outside = np.any((unit < 0) | (unit > 1), axis=1)
    control = lattices.noisy(spec, 0.5)
    out = spec.build().bind(points, outside="keep").deform(control)
    np.testing.assert_array_equal(out[outside], points[outside])
    assert np.all(np.abs(out[~outside] - points[~outside]).max(axis=1) > 0)


@each_spec
@each_dtype
@pytest.mark.parametrize("outside", ["keep", "extend"])
def test_outside_is_the_oracle(spec, dtype, outside):
    points, _ = scattered(spec, dtype)
    control = lattices.noisy(spec, 0.5)
    out = spec.build().bind(points, outside=outside).deform(control)
    atol = spec.rounding(np.abs(control).max() + np.abs(points).max(), float(np.finfo(dtype).eps))
    np.testing.assert_allclose(out, Embedded.of(spec, points, NO_TRIANGLES, outside).deform(control), rtol=0, atol=atol)


def test_keep_is_the_default():
    points, control = np.array([[1.5, 0.5, 0.5]]), lattices.noisy(Spec(), 0.5)
    np.testing.assert_array_equal(Spec().build().bind(points).deform(control), points)


@each_spec
def test_extend_moves_a_point_as_the_nearest_of_the_domain(spec):
    unit = np.array([[-0.5, 0.4, 0.3], [0.2, 1.7, 0.6], [1.4, -0.2, 2.0]])
    points, nearest = lattices.fitted(spec, unit), lattices.fitted(spec, np.clip(unit, 0, 1))
    control = lattices.noisy(spec, 0.5)
    binding = spec.build().bind(np.concatenate([points, nearest]), outside="extend")
    moved = binding.deform(control) - np.concatenate([points, nearest])
    np.testing.assert_allclose(moved[:3], moved[3:], rtol=0, atol=1e-12)


def test_what_is_a_rounding_error_outside_is_inside():
    points = np.array([[1 + 5e-10, 0.5, 0.5], [0.5, -5e-10, 0.5], [1 + 1e-6, 0.5, 0.5], [0.5, 0.5, -1e-6]])
    out = Spec().build().bind(points).deform(Spec().rest + [7.0, 0, 0])
    np.testing.assert_allclose(out[:2], points[:2] + [7.0, 0, 0], rtol=0, atol=1e-8)
    np.testing.assert_array_equal(out[2:], points[2:])


@each_spec
@each_dtype
@pytest.mark.parametrize("outside", ["keep", "extend"])
def test_influence_scales_the_displacement(spec, dtype, outside):
    points, _ = scattered(spec, dtype)
    control = lattices.noisy(spec, 0.5)
    influence = np.random.default_rng(3).random(len(points))
    influence[:3] = 0, 1, 0.5
    full = spec.build().bind(points, outside=outside).deform(control).astype(float)
    out = spec.build().bind(points, outside=outside, influence=influence).deform(control)
    atol = 2 * spec.rounding(np.abs(control).max() + np.abs(points).max(), float(np.finfo(dtype).eps))
    np.testing.assert_allclose(out, points + influence[:, None] * (full - points), rtol=0, atol=atol)
    np.testing.assert_array_equal(out[0], points[0])


def test_no_influence_at_all_is_the_identity_bit_for_bit():
    points = lattices.points_inside(Spec())
    out = Spec().build().bind(points, influence=np.zeros(len(points))).deform(lattices.noisy(Spec(), 3))
    np.testing.assert_array_equal(out, points)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.float16], ids=lambda dtype: dtype.__name__)
def test_influence_of_any_float_dtype(dtype):
    points, control = lattices.points_inside(Spec()), lattices.noisy(Spec())
    influence = np.linspace(0, 1, len(points)).astype(dtype)
    expected = Embedded.of(Spec(), points, NO_TRIANGLES, influence=influence).deform(control)
    out = Spec().build().bind(points, influence=influence).deform(control)
    np.testing.assert_allclose(out, expected, rtol=0, atol=1e-14)


@each_spec
@each_dtype
@pytest.mark.parametrize("outside", ["keep", "extend"])
def test_update_is_a_new_bind(spec, dtype, outside):
    first, triangles = meshes.bumpy_ball(seed=1)
    second = meshes.bumpy_ball(seed=2, roughness=0.6)[0] * [1.3, 1.0, 0.9]
    first, second = (lattices.fitted(spec, vertices).astype(dtype) for vertices in (first, second))
    influence = np.random.default_rng(0).random(len(first))
    options = {"outside": outside, "influence": influence, "device": "cpu"}
    updated, fresh = (spec.build().bind(vertices, triangles, **options) for vertices in (first, second))
    before = updated.reference_volume
    updated.update(second)
    control = lattices.noisy(spec)
    atol = spec.rounding(np.abs(control).max() + np.abs(second).max(), float(np.finfo(dtype).eps))
    np.testing.assert_allclose(updated.deform(control), fresh.deform(control), rtol=0, atol=atol)
    rel = 1e-12 if dtype == np.float64 else 1e-6
    assert updated.reference_volume == pytest.approx(fresh.reference_volume, rel=rel)
    assert updated.reference_volume != pytest.approx(before, rel=1e-3)
    assert updated.volume(control) == pytest.approx(fresh.volume(control), rel=rel)
    ours, theirs = updated.preserve(control), fresh.preserve(control)
    np.testing.assert_allclose(ours.control, theirs.control, rtol=0, atol=10 * atol)


def test_update_of_the_influence_or_the_lattice_alone_is_a_new_bind():
    first, second = SPECS["uniform"], SPECS["uniform"].moved(lattices.affine()[0], (0.1, 0.2, -0.1))
    mesh, influence = meshes.bumpy_ball(), np.random.default_rng(1).random(642)
    binding = first.build().bind(*mesh, outside="extend")
    binding.update(influence=influence)
    control = lattices.noisy(second)
    expected = Embedded.of(first, *mesh, "extend", influence)
    np.testing.assert_allclose(binding.deform(control), expected.deform(control), rtol=0, atol=1e-13)
    assert binding.volume(control) == pytest.approx(expected.volume(control), rel=1e-12)
    binding.update(lattice=second.build())
    expected = Embedded.of(second, *mesh, "extend", influence)
    np.testing.assert_allclose(binding.deform(control), expected.deform(control), rtol=0, atol=1e-13)
    result = binding.preserve(control)
    assert expected.volume(result.control) == pytest.approx(expected.volume(second.rest), rel=1e-12)


def test_update_can_be_repeated_and_return_to_the_start():
    spec = SPECS["uniform"]
    vertices, triangles = meshes.bumpy_ball()
    binding, control = spec.build().bind(vertices, triangles, device="cpu"), lattices.noisy(spec)
    start = binding.deform(control)
    for step in range(1, 4):
        binding.update(vertices + 0.01 * step)
    binding.update(vertices)
    np.testing.assert_allclose(binding.deform(control), start, rtol=0, atol=1e-14)
