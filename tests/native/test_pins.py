# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins: problem 2 of the paper for any number of points, as printed for one, and what cannot be pinned."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import oracle
import published
import pytest
from corrections import Correction, Solid
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import Embedded, Spec

SPECS = {
    "bernstein-2": Spec((2, 2, 2)),
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-mixed": Spec((5, 4, 6), "bspline", (2, 3, 1), "clamped"),
}
MESH = meshes.bumpy_ball(2, 0.2)
each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", cases.METHODS)


def squashed(spec: Spec, seed: int = 5) -> np.ndarray:
    return spec.centre + (lattices.noisy(spec, 0.1, seed) - spec.centre) * [1.1, 0.9, 0.5]


@each_spec
@pytest.mark.parametrize("vertex", [0, 17, 101])
def test_one_pin_is_equation_21_as_printed(spec, vertex):
    rows = Embedded.of(spec, *MESH).rows
    for seed in range(5):
        control = squashed(spec, seed)
        place = rows[vertex] @ control.reshape(-1, 3) + np.random.default_rng(seed).uniform(-0.2, 0.2, 3)
        expected = published.problem_2(
            control.reshape(-1, 3), rows, MESH[1], oracle.volume(*MESH), vertex, place
        ).reshape(control.shape)
        result = spec.build().bind(*MESH).preserve(control, method="sweep", pins=([vertex], [place]))
        assert result.method == "sweep"
        assert np.abs(result.control - expected).max() <= 1e-11 * np.abs(expected - control).max()


@each_spec
@each_method
@pytest.mark.parametrize("axes", [(1, 1, 1), (1, 1, 0), (0, 0, 1), (0, 1, 3)], ids=str)
def test_axes_without_a_share_move_as_the_pins_alone_would_move_them(spec, method, axes):
    """(1, 1, 0) with pins in x, y, z order and the volume measured first was wrong by 12 %."""
    _, asked, result = pinned(spec, method, axes=axes)
    target = oracle.volume(*MESH)
    assert oracle.volume(result.vertices, MESH[1], spec.centre) == pytest.approx(target, rel=1e-12)
    alone = asked.pinned()
    still = np.array(axes) == 0
    np.testing.assert_allclose(result.control[..., still], alone[..., still], rtol=0, atol=1e-12)


def pinned(spec: Spec, method: str, chosen=(3, 77), **options):
    """The lattice, the oracle's task and the library's result of a task with pins."""
    control, embedded = squashed(spec), Embedded.of(spec, *MESH)
    chosen = list(chosen)
    moves = np.random.default_rng(1).uniform(-0.1, 0.1, (len(chosen), 3))
    places = embedded.deform(control)[chosen] + moves
    asked = Correction(Solid.of(embedded), control, pin_rows=embedded.rows[chosen], pin_moves=moves, **options)
    result = spec.build().bind(*MESH).preserve(control, method=method, pins=(chosen, places), **options)
    size = np.ptp(result.vertices, axis=0).max()
    np.testing.assert_allclose(result.vertices[chosen], places, rtol=0, atol=1e-12 * size)
    return control, asked, result


@each_spec
@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient"])
def test_several_pins_are_the_closed_form(spec, method):
    weights = np.exp(np.random.default_rng(2).uniform(0, 5, spec.shape))
    for options in ({}, {"weights": weights}, {"axes": (2, 1, 0)}, {"amount": 0.4}, {"frame": lattices.rotation()}):
        control, asked, result = pinned(spec, method, **options)
        expected = getattr(asked, method)()
        assert result.method == method
        assert np.abs(result.control - expected).max() <= 1e-9 * np.abs(expected - control).max()


@each_method
def test_an_oblique_frame(method):
    """Unit rows that are not orthogonal: pins still move by what they have to, in all."""
    rows = np.array([[1.0, 0.2, 0.1], [-0.3, 0.9, 0.4], [0.2, -0.5, 1.1]])
    spec = SPECS["uniform-6"]
    for axes in ((1, 1, 1), (0, 1, 1), (1, 0, 0)):
        result = pinned(spec, method, axes=axes, frame=rows)[2]
        assert oracle.volume(result.vertices, MESH[1], spec.centre) == pytest.approx(oracle.volume(*MESH), rel=1e-12)


@each_spec
@each_method
def test_amount_0_has_no_volume_row(spec, method):
    """Figure 7, top middle: the pins alone, whatever that does to the volume."""
    _, asked, result = pinned(spec, method, amount=0.0)
    np.testing.assert_allclose(result.control, asked.pinned(), rtol=0, atol=1e-12)
    assert result.target == pytest.approx(asked.solid.volumes(asked.pinned())[0], rel=1e-12)
    assert abs(result.target / oracle.volume(*MESH) - 1) > 1e-3
    assert result.error <= 1e-12


@each_method
@pytest.mark.parametrize("amount", [0.25, 1.0, 1.5])
def test_amount_runs_from_the_volume_with_the_pins_alone(method, amount):
    _, asked, result = pinned(SPECS["bernstein-4"], method, amount=amount)
    alone = asked.solid.volumes(asked.pinned())[0]
    assert result.target == pytest.approx(alone + amount * (oracle.volume(*MESH) - alone), rel=1e-12)
    assert result.volume == pytest.approx(result.target, rel=1e-12)


@each_method
def test_a_pin_that_stands_already_holds_its_point_against_the_correction(method):
    spec = SPECS["bernstein-4"]
    control, binding = squashed(spec), spec.build().bind(*MESH)
    places = binding.deform(control)[[5, 60, 130]]
    held = binding.preserve(control, method=method, pins=([5, 60, 130], places))
    np.testing.assert_allclose(held.vertices[[5, 60, 130]], places, rtol=0, atol=1e-12)
    free = binding.preserve(control, method=method)
    assert np.abs(free.vertices[[5, 60, 130]] - places).max() > 1e-3
    assert held.distance > free.distance * (1 - 1e-9) or method != "nearest"


@each_method
def test_a_face_point_is_a_pin_like_any(method):
    spec, random = SPECS["uniform-6"], np.random.default_rng(3)
    control, binding = squashed(spec), spec.build().bind(*MESH)
    faces, barycentric = np.array([4, 150, 222]), random.dirichlet([1, 1, 1], 3)
    places = np.einsum("pk,pkx->px", barycentric, binding.deform(control)[MESH[1][faces]]) + 0.05
    result = binding.preserve(control, method=method, pins=isochor.Pins(faces, places, barycentric))
    landed = np.einsum("pk,pkx->px", barycentric, result.vertices[MESH[1][faces]])
    np.testing.assert_allclose(landed, places, rtol=0, atol=1e-12)
    assert result.volume == pytest.approx(oracle.volume(*MESH), rel=1e-12)


def test_a_corner_of_a_face_is_its_vertex():
    spec = SPECS["bernstein-4"]
    control, binding = squashed(spec), spec.build().bind(*MESH)
    faces = np.array([7, 100])
    vertices, corner = MESH[1][faces, 1], np.array([[0.0, 1, 0], [0, 1, 0]])
    places = binding.deform(control)[vertices] + 0.04
    one = binding.preserve(control, pins=(vertices, places)).control
    other = binding.preserve(control, pins=isochor.Pins(faces, places, corner)).control
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-12)
    same = binding.preserve(control, pins=isochor.Pins(vertices, places)).control
    np.testing.assert_array_equal(same, one)


def test_no_pins_are_none():
    control, binding = squashed(Spec()), Spec().build().bind(*MESH)
    for method in cases.METHODS:
        empty = binding.preserve(control, method=method, pins=([], np.zeros((0, 3))))
        np.testing.assert_array_equal(empty.control, binding.preserve(control, method=method).control)


@each_method
def test_the_order_of_the_pins_does_not_matter(method):
    spec = SPECS["uniform-6"]
    control, binding = squashed(spec), spec.build().bind(*MESH)
    chosen = np.array([3, 50, 77, 120])
    places = binding.deform(control)[chosen] + np.random.default_rng(0).uniform(-0.05, 0.05, (4, 3))
    one = binding.preserve(control, method=method, pins=(chosen, places)).control
    other = binding.preserve(control, method=method, pins=(chosen[::-1], places[::-1])).control
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-9)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    shape=st.tuples(*[st.integers(2, 5)] * 3),
    uniform=st.booleans(),
    squash=st.floats(0.05, 3),
    pins=st.lists(st.integers(0, 161), min_size=1, max_size=3, unique=True),
    pull=st.floats(-0.2, 0.2),
    shares=st.tuples(*[st.integers(0, 2)] * 3).filter(any),
    method=st.sampled_from(cases.METHODS),
    single=st.booleans(),
)
def test_pins_and_volume_of_any_shape(shape, uniform, squash, pins, pull, shares, method, single):
    spec = Spec(shape, "bspline", tuple(n - 1 for n in shape), "uniform") if uniform else Spec(shape)
    vertices = MESH[0].astype(np.float32 if single else np.float64)
    control = spec.centre + (lattices.noisy(spec, 0.05) - spec.centre) * squash
    case = cases.Case("none", spec, vertices, MESH[1], control)
    case.options = {"axes": tuple(map(float, shares))}
    case.pins = np.array(pins), np.full((len(pins), 3), pull) * [1, -0.5, 0.25], None
    if cases.solvable(case):
        cases.check_exact(case, case.bind().preserve(case.control, method=method, **case.arguments))
