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
from isochor import PinError, VolumeError
from oracle import Embedded, Spec
from refusals import refused

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


BINDING = Spec().build().bind(*MESH)
REST = Spec().rest
each_target = pytest.mark.parametrize("apart", [0.0, 0.1], ids=["same-target", "contradicting"])


@each_target
@each_method
def test_a_repeated_pin_is_named(apart, method):
    places = MESH[0][[9, 42, 9]] + [[0, 0, 0], [0, 0, 0], [apart, 0, 0]]
    with refused(PinError, 0, 2, 9):
        BINDING.preserve(REST, method=method, pins=([9, 42, 9], places))


@each_target
def test_a_face_point_on_a_pinned_vertex_is_named(apart):
    face = int(np.flatnonzero((MESH[1] == 9).any(axis=1))[0])
    corner = (MESH[1][face] == 9).astype(float)
    twice = np.stack([corner, corner])
    with refused(PinError, "pin", 0, 1):
        BINDING.preserve(REST, pins=isochor.Pins([face, face], [MESH[0][9], MESH[0][9] + apart], twice))


@each_target
def test_two_vertices_at_one_place_cannot_be_pinned_apart(apart):
    double = meshes.joined(MESH, MESH)
    other = 9 + len(MESH[0])
    binding = Spec().build().bind(*double)
    with refused(PinError, "pin", (0, 9), (1, other)):
        binding.preserve(REST, pins=([9, other], [MESH[0][9], MESH[0][9] + apart]))


def test_more_pins_than_the_lattice_has_points():
    """Nine pins on a lattice of eight points: the last depends on the others."""
    chosen = np.arange(9) * 13
    binding = Spec((2, 2, 2)).build().bind(*MESH)
    with refused(PinError, "pin"):
        binding.preserve(Spec((2, 2, 2)).rest, pins=(chosen, MESH[0][chosen] * 1.1))


def test_pins_on_one_line_that_the_lattice_keeps_straight():
    """Trilinear lattices keep a line along an axis straight: three points of it are dependent, two are not."""
    vertices, triangles = meshes.box(4)
    line = [int(np.argmin(np.abs(vertices - [x, 0.1, 0.1]).sum(axis=1))) for x in (0.1, 0.5, 0.9)]
    spec = Spec((2, 2, 2))
    binding = spec.build().bind(vertices, triangles)
    places = vertices[line] + [[0, 0, 0], [0, 0.1, 0], [0, 0, 0]]
    with refused(PinError, "pin", (2, line[2])):
        binding.preserve(spec.rest, pins=(line, places))
    binding.preserve(spec.rest, pins=(line[:2], places[:2]))


IMMOVABLE = {
    "masked": ({"influence": np.where(np.arange(len(MESH[0])) == 42, 0.0, 1.0)}, {}),
    "outside": ({"outside": "keep"}, {}),
    "frozen": ({}, {"weights": np.full((4, 4, 4), np.inf)}),
}


@pytest.mark.parametrize("why", IMMOVABLE)
def test_a_pin_that_nothing_can_move_is_named(why):
    bound, options = IMMOVABLE[why]
    offset = np.array([0.0, 0.0, 0.4]) if why == "outside" else np.zeros(3)
    vertices = MESH[0] + offset
    top = 42 if why != "outside" else int(np.argmax(vertices[:, 2]))
    low = int(np.argmin(vertices[:, 2]))
    lattice = Spec((6, 6, 6), "bspline", 1, "clamped").build() if why == "outside" else Spec().build()
    binding = lattice.bind(vertices, MESH[1], **bound)
    with refused(PinError, "pin", (1, top) if why != "frozen" else (0, low)):
        binding.preserve(lattice.rest, pins=([low, top], vertices[[low, top]] + 0.05), **options)


def test_pins_that_leave_the_volume_no_freedom():
    """All corners of a tetrahedron pinned: the volume is that of the pinned corners, and the error says it."""
    vertices, triangles = meshes.tetrahedron()
    places = vertices * [1, 1, 0.5]
    with refused(VolumeError, "volume") as caught:
        Spec().build().bind(vertices, triangles).preserve(REST, pins=([0, 1, 2, 3], places))
    assert says_number(str(caught.value), oracle.volume(places, triangles))


def test_a_volume_already_right_needs_no_freedom():
    vertices, triangles = meshes.tetrahedron()
    places = vertices @ lattices.rotation().T + 0.1
    result = Spec().build().bind(vertices, triangles).preserve(REST, pins=([0, 1, 2, 3], places))
    np.testing.assert_allclose(result.vertices, places, rtol=0, atol=1e-12)


@pytest.mark.parametrize("apart", 10.0 ** -np.arange(3, 15, 2))
@each_method
def test_nearly_dependent_pins_are_exact_or_refused_but_never_wild(apart, method):
    """Two points of a face, `apart` of it from each other, pulled apart by as much: a slope of about 1 is wanted."""
    spec = Spec()
    control, binding = squashed(spec), spec.build().bind(*MESH)
    barycentric = np.array([[0.3, 0.3, 0.4], [0.3 + apart, 0.3, 0.4 - apart]])
    corners = binding.deform(control)[MESH[1][[11, 11]]]
    places = np.einsum("pk,pkx->px", barycentric, corners) + [[0.05, 0, 0], [0.05, 0.1 * apart, 0]]
    try:
        result = binding.preserve(control, method=method, pins=isochor.Pins([11, 11], places, barycentric))
    except PinError:
        assert apart < 1e-6
        return
    landed = np.einsum("pk,pkx->px", barycentric, result.vertices[MESH[1][[11, 11]]])
    np.testing.assert_allclose(landed, places, rtol=0, atol=1e-12)
    assert np.abs(result.control - control).max() < 5


@pytest.mark.parametrize(
    ("pins", "said"),
    [
        (lambda: isochor.Pins([10**6], [[0.0, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0], [[np.nan, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0, 1], [[0.0, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0], [[0.0, 0, 0]], [[0.5, np.nan, 0.5]]), ("barycentric", "pin")),
        (lambda: isochor.Pins([0], [[0.0, 0, 0]], [[0.5, 0.5]]), ("barycentric", "pin")),
        (lambda: isochor.Pins([10**6], [[0.0, 0, 0]], [[0.2, 0.3, 0.5]]), "pin"),
        (lambda: isochor.Pins([-1], [[0.0, 0, 0]]), "pin"),
    ],
)
def test_pins_that_are_none(pins, said):
    with refused(isochor.Error, said):
        BINDING.preserve(REST, pins=pins())


def says_number(message: str, value: float, rel: float = 1e-3) -> bool:
    """Whether the message names the value, to a thousandth."""
    return any(abs(found - value) <= rel * abs(value) for found in cases.numbers(message))
