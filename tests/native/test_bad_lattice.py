# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that cannot be a lattice is refused with a LatticeError that says what was found and expected."""

import isochor
import numpy as np
import pytest
from isochor import Lattice, LatticeError
from refusals import refused

NAN, INF = float("nan"), float("inf")
UNIT = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
CUBE = (4, 4, 4)


def test_the_family_of_exceptions():
    for kind in (isochor.LatticeError, isochor.MeshError, isochor.VolumeError, isochor.PinError):
        assert issubclass(kind, isochor.Error)
        assert issubclass(kind, ValueError)
    assert issubclass(isochor.DeviceError, isochor.Error)
    assert issubclass(isochor.DeviceError, RuntimeError)


@pytest.mark.parametrize(
    "shape",
    [
        (0, 4, 4),
        (4, -1, 4),
        (4, 4),
        (4, 4, 4, 4),
        (),
        4,
        (4.5, 4, 4),
        ("4", "4", "4"),
        "444",
        (4, None, 4),
        (NAN, 4, 4),
        {"nu": 4},
        (2**70, 4, 4),
    ],
    ids=repr,
)
def test_shape(shape):
    with refused(LatticeError, "shape"):
        Lattice(shape=shape)


@pytest.mark.parametrize("shape", [(10**9, 10**9, 10**9), (10**6, 10**6, 10**6), (2**32, 2**32, 1)])
def test_shape_beyond_any_memory(shape):
    with refused(LatticeError, "shape"):
        Lattice(shape=shape, basis="bspline", degree=3)
    with refused(LatticeError, "shape"):
        Lattice(shape=shape)


@pytest.mark.parametrize("basis", ["bezier", "", "BSPLINES", None, 3, b"bernstein"], ids=repr)
def test_unknown_basis_lists_the_choices(basis):
    with refused(LatticeError, "basis", "bernstein", "bspline"):
        Lattice(shape=CUBE, basis=basis)


@pytest.mark.parametrize("degree", [0, -1, 9, 100, 2.5, "cubic", (3, 3), (3, 3, 3, 3), (3, 0, 3), (3, 3, 9)], ids=repr)
def test_degree(degree):
    with refused(LatticeError, "degree"):
        Lattice(shape=(9, 9, 9), basis="bspline", degree=degree)


def test_the_range_of_degrees_is_said():
    with refused(LatticeError, "degree", 12, 9, 1, 8):
        Lattice(shape=(9, 9, 9), basis="bspline", degree=12)


@pytest.mark.parametrize("knots", ["uniform", "clamped"])
@pytest.mark.parametrize(("shape", "degree"), [((3, 9, 9), 3), ((9, 2, 9), 2), ((9, 9, 5), (1, 1, 5))])
def test_too_few_points_for_the_degree(shape, degree, knots):
    found = degree if isinstance(degree, int) else max(degree)
    with refused(LatticeError, "degree", "point", found, 1):
        Lattice(shape=shape, basis="bspline", degree=degree, knots=knots)


GOOD_KNOTS = (0, 0, 0, 0, 1, 1, 1, 1)


@pytest.mark.parametrize(
    "knots",
    [
        "open",
        "",
        None,
        7,
        (GOOD_KNOTS, GOOD_KNOTS),
        (GOOD_KNOTS, GOOD_KNOTS, GOOD_KNOTS[1:]),
        (GOOD_KNOTS, GOOD_KNOTS, (*GOOD_KNOTS, 2)),
        (GOOD_KNOTS, GOOD_KNOTS, GOOD_KNOTS[::-1]),
        (GOOD_KNOTS, GOOD_KNOTS, (0, 0, 0, 0, NAN, 1, 1, 1)),
        (GOOD_KNOTS, GOOD_KNOTS, (0, 0, 0, 0, 1, 1, 1, INF)),
        (GOOD_KNOTS, GOOD_KNOTS, (0, 0, 0, 0, 0, 0, 0, 0)),
        (GOOD_KNOTS, GOOD_KNOTS, (-1, -0.5, -0.2, 0, 0, 1, 2, 3)),
        (GOOD_KNOTS, GOOD_KNOTS, "uniformly"),
        (GOOD_KNOTS, GOOD_KNOTS, ()),
    ],
    ids=repr,
)
def test_knots(knots):
    with refused(LatticeError, "knot"):
        Lattice(shape=CUBE, basis="bspline", degree=3, knots=knots)


def test_unknown_knots_list_the_choices():
    with refused(LatticeError, "open", "uniform", "clamped"):
        Lattice(shape=CUBE, basis="bspline", degree=3, knots="open")


@pytest.mark.parametrize("origin", [(0, 0), (0, 0, 0, 0), (0, NAN, 0), (INF, 0, 0), "abc", 5, (0, "1", 0)], ids=repr)
def test_origin(origin):
    with refused(LatticeError, ("origin", "frame")):
        Lattice(shape=CUBE, origin=origin)


@pytest.mark.parametrize(
    "edges",
    [
        ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
        np.zeros((3, 3)),
        ((1, 0, 0), (2, 0, 0), (0, 0, 1)),
        ((1, 2, 3), (4, 5, 6), (7, 8, 9)),
        ((1, 1, 0), (0, 1, 1), (1, 2, 1)),
        ((NAN, 0, 0), (0, 1, 0), (0, 0, 1)),
        ((1, 0, 0), (0, INF, 0), (0, 0, 1)),
        ((1, 0), (0, 1)),
        np.eye(4),
        (1, 1, 1),
        "xyz",
    ],
    ids=repr,
)
def test_edges(edges):
    with refused(LatticeError, ("edge", "frame")):
        Lattice(shape=CUBE, edges=edges)


def test_a_flat_but_valid_needle_is_not_refused():
    """Singular means singular: very unequal edges are a frame."""
    lattice = Lattice(shape=CUBE, edges=((1e6, 0, 0), (0, 1, 0), (0, 0, 1e-6)))
    np.testing.assert_allclose(lattice.parameters([[5e5, 0.5, 5e-7]]), [[0.5, 0.5, 0.5]], atol=1e-14)


@pytest.mark.parametrize(
    "weights", [np.zeros(CUBE), -np.ones(CUBE), np.full(CUBE, NAN), np.ones((4, 4)), "heavy"], ids=str
)
def test_rational_weights(weights):
    with refused(LatticeError, "weight"):
        Lattice(shape=CUBE, weights=weights)


@pytest.mark.parametrize(
    "vertices",
    [
        np.zeros((0, 3)),
        np.array([[0, 0, 0], [1, 1, NAN]]),
        np.array([[0, 0, 0], [1, INF, 1]]),
        np.ones((5, 2)),
        np.ones(3),
        "vertices",
        None,
    ],
    ids=["empty", "nan", "inf", "two-columns", "one-dimension", "string", "none"],
)
def test_around(vertices):
    with refused(isochor.Error, ("vert", "point", "size", "extent", "edge")):
        Lattice.around(vertices, shape=CUBE)


@pytest.mark.parametrize("margin", [NAN, INF, -10.0, "wide", None], ids=repr)
def test_margin(margin):
    with refused(LatticeError, "margin"):
        Lattice.around(np.random.default_rng(0).random((9, 3)), shape=CUBE, margin=margin)


@pytest.mark.parametrize(
    "points", [np.ones((4, 2)), np.ones(3), [[0, 0, NAN]], [[INF, 0, 0]], "points", None, [["a", "b", "c"]]], ids=repr
)
def test_parameters_of_bad_points(points):
    with refused(isochor.Error):
        Lattice(shape=CUBE).parameters(points)


@pytest.mark.parametrize(
    "parameters", [np.ones((4, 2)), np.ones(3), [[0, 0, NAN]], [[0, 0, -INF]], "x", None], ids=repr
)
def test_evaluate_at_bad_parameters(parameters):
    lattice = Lattice(shape=CUBE)
    with refused(isochor.Error):
        lattice.evaluate(parameters, lattice.rest)


@pytest.mark.parametrize(
    "control",
    [
        np.zeros((4, 4, 4)),
        np.zeros((64, 3)),
        np.zeros((4, 4, 3, 3)),
        np.zeros((4, 4, 4, 4)),
        np.full((4, 4, 4, 3), NAN),
        "rest",
        None,
        np.zeros((4, 4, 4, 3), complex),
    ],
    ids=lambda control: str(getattr(control, "shape", control)),
)
def test_control_points_in_every_call_that_takes_them(control):
    lattice = Lattice(shape=CUBE)
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    binding = lattice.bind(points, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    for call in (
        lambda: lattice.evaluate(points, control),
        lambda: binding.deform(control),
        lambda: binding.volume(control),
        lambda: binding.preserve(control),
    ):
        with refused(LatticeError, "control"):
            call()


def test_the_shape_found_and_expected_are_said():
    lattice = Lattice(shape=(4, 5, 6))
    with refused(LatticeError, 7, 4, 5, 6, 3):
        lattice.bind(np.ones((1, 3))).deform(np.zeros((4, 5, 7, 3)))


def test_the_first_control_point_that_is_not_finite_is_named():
    lattice = Lattice(shape=CUBE)
    control = lattice.rest.copy()
    control[1, 2, 3, 0] = NAN
    control[3, 3, 0, 2] = INF
    with refused(LatticeError, "control", 2, (1, "[1, 2, 3]", "(1, 2, 3)")):
        lattice.bind(np.ones((1, 3))).deform(control)
