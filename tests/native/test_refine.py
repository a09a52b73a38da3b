# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice with more control points for the same shape: the map, the deformed mesh and its volume stay."""

import isochor
import lattices
import meshes
import numpy as np
import pytest
from isochor import Lattice, LatticeError
from lattices import SOLID, THIN
from refusals import refused

EVERY = {**SOLID, **THIN}
each_lattice = pytest.mark.parametrize("spec", EVERY.values(), ids=EVERY)
PARAMETERS = np.random.default_rng(8).uniform(-0.2, 1.2, (200, 3))


def unchanged(lattice, control, **how):
    """Refines, checks that no parameter moves by more than 1e-13 of the shape's size, and gives lattice and control."""
    finer, fine_control = lattice.refine(control, **how)
    before, after = lattice.evaluate(PARAMETERS, control), finer.evaluate(PARAMETERS, fine_control)
    size = np.abs(control).max() + np.abs(lattice.rest).max()
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-13 * size)
    assert fine_control.shape == (*finer.shape, 3)
    return finer, fine_control


@each_lattice
def test_degrees_raised_by_two(spec):
    lattice = spec.build()
    control = lattices.noisy(spec, 0.7) if spec in SOLID.values() else lattice.rest + 0.3
    degree = [d + 2 if n > 1 else d for d, n in zip(lattice.degree, lattice.shape, strict=True)]
    finer, _ = unchanged(lattice, control, degree=degree)
    assert finer.degree == tuple(degree)
    assert finer.basis == lattice.basis


@each_lattice
def test_knots_inserted(spec):
    lattice = spec.build()
    control = lattices.noisy(spec, 0.7) if spec in SOLID.values() else lattice.rest + 0.3
    insert = [[0.9, 0.3, 0.31] if n > 1 else None for n in lattice.shape]
    finer, _ = unchanged(lattice, control, insert=insert)
    assert finer.basis == ("bspline" if max(lattice.shape) > 1 else "bernstein")
    for fine, coarse, added in zip(finer.knots, lattice.knots, insert, strict=True):
        assert set(added or ()) <= set(fine.tolist())
        assert len(fine) == len(coarse) + len(added or ())


@each_lattice
def test_more_points(spec):
    lattice = spec.build()
    control = lattices.noisy(spec, 0.7) if spec in SOLID.values() else lattice.rest + 0.3
    shape = tuple(n + more if n > 1 else 1 for n, more in zip(lattice.shape, (1, 4, 7), strict=True))
    finer, _ = unchanged(lattice, control, shape=shape)
    assert finer.shape == shape
    if lattice.basis == "bernstein":
        assert finer.degree == tuple(n - 1 for n in shape)
    else:
        assert finer.degree == lattice.degree


@each_lattice
def test_rest_goes_to_rest(spec):
    lattice = spec.build()
    finer, rest = lattice.refine(lattice.rest, degree=[d + 1 if d else 0 for d in lattice.degree])
    assert np.array_equal(rest, finer.rest)


def test_a_raised_lattice_is_made_by_its_own_description():
    lattice = Lattice((4, 3, 5), origin=(1, 2, 3), edges=lattices.OBLIQUE)
    finer, _ = lattice.refine(lattice.rest, shape=(7, 4, 5))
    fresh = Lattice((7, 4, 5), origin=(1, 2, 3), edges=lattices.OBLIQUE)
    assert np.array_equal(finer.rest, fresh.rest)
    general = Lattice((6, 6, 6), "bspline", 3, "uniform")
    finer, _ = general.refine(general.rest, insert=([0.4], [0.2, 0.8], None))
    again = Lattice(finer.shape, "bspline", finer.degree, finer.knots)
    assert np.array_equal(again.evaluate(PARAMETERS, finer.rest * 2), finer.evaluate(PARAMETERS, finer.rest * 2))


def test_halving_every_span_keeps_a_lattice_uniform():
    lattice = Lattice((6, 5, 4), "bspline", 3, "uniform")
    finer, _ = unchanged(lattice, lattice.rest * [1, 2, 3], shape=(9, 7, 5))
    for fine, uniform in zip(finer.knots, Lattice((9, 7, 5), "bspline", 3, "uniform").knots, strict=True):
        assert np.array_equal(fine, uniform)


def test_shape_keys_are_refined_together():
    lattice = Lattice((5, 5, 5), "bspline", 3, "clamped")
    random = np.random.default_rng(3)
    keys = lattice.rest + random.normal(size=(4, *lattice.shape, 3))
    finer, fine_keys = lattice.refine(keys, degree=4, insert=([0.3], None, None))
    assert fine_keys.shape == (4, *finer.shape, 3)
    for key, fine in zip(keys, fine_keys, strict=True):
        assert np.array_equal(lattice.refine(key, degree=4, insert=([0.3], None, None))[1], fine)
    weights = random.normal(size=4)
    blended = finer.evaluate(PARAMETERS, finer.blend(fine_keys, weights))
    np.testing.assert_allclose(blended, lattice.evaluate(PARAMETERS, lattice.blend(keys, weights)), atol=1e-13)


def test_mesh_and_volume_stay_and_the_finer_lattice_corrects():
    vertices, triangles = meshes.icosphere(3)
    lattice = Lattice.around(vertices, (6, 6, 6), "bspline", margin=0.05)
    control = lattice.rest * [1.1, 0.9, 0.6]
    finer, fine_control = lattice.refine(control, shape=(9, 9, 9))
    coarse, fine = (each.bind(vertices, triangles, device="cpu") for each in (lattice, finer))
    np.testing.assert_allclose(fine.deform(fine_control), coarse.deform(control), rtol=0, atol=1e-14)
    result = fine.preserve(fine_control)
    assert result.error < 1e-12


@each_lattice
def test_what_is_bound_to_a_rational_lattice_moves_as_before(spec):
    plain = spec.build()
    weights = np.random.default_rng(6).uniform(0.1, 3, plain.shape)
    knots = {} if plain.basis == "bernstein" else {"degree": [max(d, 1) for d in plain.degree], "knots": plain.knots}
    lattice = Lattice(plain.shape, plain.basis, origin=plain.origin, edges=plain.edges, weights=weights, **knots)
    control = lattices.noisy(spec, 0.7) if spec in SOLID.values() else lattice.rest + 0.3
    insert = [[0.41] if n > 1 else None for n in lattice.shape]
    finer, fine_control = lattice.refine(control, degree=[d + 1 if d else 0 for d in lattice.degree], insert=insert)
    assert finer.weights.shape == finer.shape
    points = lattices.points_inside(spec)
    before, after = (
        each.bind(points, device="cpu", outside="extend").deform(moved)
        for each, moved in ((lattice, control), (finer, fine_control))
    )
    size = np.abs(control).max() + np.abs(lattice.rest).max()
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-13 * size)
    finer, fine_rest = lattice.refine(lattice.rest, insert=insert)
    assert np.array_equal(fine_rest, finer.rest)


def test_blenders_linear_lattices_are_refined_evenly():
    lattice = Lattice((4, 3, 1), "blender", interpolation="linear")
    control = lattice.rest + np.random.default_rng(7).normal(size=(4, 3, 1, 3))
    finer, _ = unchanged(lattice, control, shape=(7, 9, 1))
    assert (finer.basis, finer.interpolation) == ("blender", ("linear",) * 3)
    thirds, _ = unchanged(lattice, control, insert=([i / 9 for i in range(1, 9) if i % 3], None, None))
    assert thirds.shape == (10, 3, 1)
    with refused(LatticeError, "shape", "evenly", 7):
        lattice.refine(control, shape=(6, 3, 1))
    with refused(LatticeError, "evenly"):
        lattice.refine(control, degree=2)
    cubic = Lattice((4, 4, 4), "blender")
    with refused(LatticeError, "Blender", "axis s", "B-spline"):
        cubic.refine(cubic.rest, shape=(7, 7, 7))


def test_what_cannot_be_refined():
    lattice = Lattice((5, 5, 5), "bspline", 3, "clamped")
    rest = lattice.rest
    with refused(LatticeError, "degree", 2, "axis s"):
        lattice.refine(rest, degree=2)
    with refused(LatticeError, "shape", 4):
        lattice.refine(rest, shape=(5, 4, 5))
    with refused(LatticeError, "shape", 64):
        lattice.refine(rest, shape=(5, 65, 5))
    with refused(LatticeError, "insert", "between 0 and 1"):
        lattice.refine(rest, insert=(None, [1.0], None))
    with refused(LatticeError, "insert", "three"):
        lattice.refine(rest, insert=(None, [0.5]))
    with refused(LatticeError, "repeated", 3):
        lattice.refine(rest, insert=(None, [0.25] * 4, None))
    with refused(LatticeError, "control", "shape"):
        lattice.refine(rest[1:])
    cubic = Lattice((4, 4, 4))
    with refused(LatticeError, "degree", 5, "leave"):
        cubic.refine(cubic.rest, shape=(5, 5, 5), degree=5)
    thin = Lattice((4, 4, 1))
    with refused(LatticeError, "axis u", "one control point"):
        thin.refine(thin.rest, shape=(5, 5, 2))


@each_lattice
def test_derivative_is_the_limit_of_differences(spec):
    lattice = spec.build()
    control = lattices.noisy(spec, 0.7) if spec in SOLID.values() else lattice.rest * 1.1
    inside = np.random.default_rng(4).uniform(0.02, 0.98, (100, 3))
    found = lattice.derivative(inside, control)
    assert found.shape == (100, 3, 3)
    step = 1e-6
    for axis, knots in enumerate(lattice.knots):
        way = step * np.eye(3)[axis]
        rows = (lattice.evaluate(inside + way, control) - lattice.evaluate(inside - way, control)) / (2 * step)
        clear = np.abs(inside[:, axis, None] - knots).min(axis=1) > step
        scale = np.abs(found[:, axis]).max()
        np.testing.assert_allclose(found[clear, axis], rows[clear], rtol=0, atol=1e-5 * scale)


def test_blend():
    lattice = Lattice((3, 4, 2))
    sets = lattice.rest + np.random.default_rng(5).normal(size=(3, *lattice.shape, 3))
    assert np.array_equal(lattice.blend(sets, np.zeros(3)), lattice.rest)
    np.testing.assert_allclose(lattice.blend(sets, [0.2, 0.3, 0.5]), np.tensordot([0.2, 0.3, 0.5], sets, 1), atol=1e-15)
    relative = lattice.rest + 2 * (sets[0] - lattice.rest) - (sets[2] - lattice.rest)
    np.testing.assert_allclose(lattice.blend(sets, [2, 0, -1]), relative, atol=1e-14)
    assert np.array_equal(lattice.blend(np.zeros((0, *lattice.shape, 3)), []), lattice.rest)
    with refused(LatticeError, "weights", 2, 3):
        lattice.blend(sets, [1, 2])
    with refused(LatticeError, "weights", "NaN"):
        lattice.blend(sets, [1, 2, float("nan")])
    with refused(LatticeError, "sets", "shape"):
        lattice.blend(sets[0], [1])


def test_knots_are_those_of_the_basis():
    clamped = Lattice((5, 4, 1), "bspline", 3, "clamped")
    assert [k.tolist() for k in clamped.knots] == [[0, 0, 0, 0, 0.5, 1, 1, 1, 1], [0] * 4 + [1] * 4, [0, 1]]
    assert isochor.Lattice((3, 3, 3)).knots[1].tolist() == [0, 0, 0, 1, 1, 1]
