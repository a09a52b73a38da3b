# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be weights, a joint, a refinement, a surface, a chain or a patch model is refused in words."""

import isochor
import meshes
import numpy as np
import pytest
from isochor import Lattice, LatticeError, MeshError
from refusals import refused

NAN, INF = float("nan"), float("inf")
CUBE = (4, 4, 4)
REST = Lattice(shape=CUBE).rest
BALL = meshes.icosphere(1)


@pytest.mark.parametrize(
    "weights",
    [
        np.zeros(CUBE),
        -np.ones(CUBE),
        np.full(CUBE, NAN),
        np.full(CUBE, INF),
        np.ones((4, 4)),
        np.ones((4, 4, 5)),
        np.ones((4, 4, 4, 1)),
        np.ones(64),
        "heavy",
        3.0,
        np.ones(CUBE, complex),
    ],
    ids=lambda w: f"{getattr(w, 'shape', w)}-{np.ravel(w)[0]}",
)
@pytest.mark.parametrize("around", [False, True])
def test_weights(weights, around):
    with refused(LatticeError, "weight"):
        if around:
            Lattice.around(BALL[0], shape=CUBE, weights=weights)
        else:
            Lattice(shape=CUBE, weights=weights)


def test_the_first_bad_weight_is_named():
    weights = np.ones(CUBE)
    weights[1, 2, 3] = -0.5
    weights[3, 3, 3] = 0.0
    with refused(LatticeError, "weight", "-0.5", ("[1, 2, 3]", "(1, 2, 3)"), 2):
        Lattice(shape=CUBE, weights=weights)


def test_good_weights_are_given_back_and_none_is_none():
    weights = np.random.default_rng(0).uniform(0.1, 10, CUBE)
    given = Lattice(shape=CUBE, weights=weights)
    np.testing.assert_array_equal(given.weights, weights)
    weights[:] = -1  # what the caller does with his array afterwards is his
    assert given.weights.min() > 0
    assert Lattice(shape=CUBE).weights is None


@pytest.mark.parametrize(
    "interpolation",
    [
        "cubic",
        "",
        3,
        "BSPLINE ",
        ("linear", "linear"),
        ("linear", "linear", "spline"),
        ("linear",) * 4,
        b"linear",
    ],
    ids=repr,
)
def test_interpolation_lists_the_choices(interpolation):
    with refused(LatticeError, "interpolation", "linear", "cardinal", "catmull-rom", "bspline"):
        Lattice(shape=CUBE, basis="blender", interpolation=interpolation)


def test_the_basis_lists_blender_too():
    with refused(LatticeError, "basis", "bernstein", "bspline", "blender"):
        Lattice(shape=CUBE, basis="blend")


@pytest.mark.parametrize("shape", [(65, 4, 4), (0, 4, 4), (4, 4, 1000)])
def test_blenders_lattices_end_where_blenders_do(shape):
    with refused(LatticeError, "shape"):
        Lattice(shape=shape, basis="blender")


def test_interpolation_is_told():
    assert Lattice(shape=CUBE, basis="blender", interpolation="cardinal").interpolation == ("cardinal",) * 3
    mixed = ("linear", "catmull-rom", "bspline")
    lattice = Lattice(shape=CUBE, basis="blender", interpolation=mixed)
    assert (lattice.interpolation, lattice.basis) == (mixed, "blender")


@pytest.mark.parametrize("continuity", [-1, 1.5, "smooth", NAN, INF, (1,)], ids=repr)
def test_continuity(continuity):
    lattice = Lattice(shape=(6, 6, 6), basis="bspline", degree=3)
    with refused(LatticeError, "continuity"):
        lattice.frozen(continuity=continuity)
    with refused(LatticeError, "continuity"):
        lattice.bind(BALL[0], continuity=continuity)


def test_more_continuity_than_there_are_layers_freezes_all_that_matter():
    for lattice in (
        Lattice(shape=(8, 8, 8), basis="bspline", degree=3),
        Lattice(shape=CUBE),
        Lattice(shape=CUBE, basis="blender", interpolation="cardinal"),
    ):
        most = lattice.frozen(continuity=10**9, faces=("s0",))
        assert (most == lattice.frozen(continuity=20, faces=("s0",))).all()
        assert (most >= lattice.frozen(continuity=2, faces=("s0",))).all()


@pytest.mark.parametrize("faces", [("x0",), ("s0", "s2"), "s", 3, None, ("s0", 1)], ids=repr)
def test_faces(faces):
    with refused(LatticeError, "face", "s0", "u1"):
        Lattice(shape=CUBE).frozen(continuity=0, faces=faces)


def test_no_faces_freeze_nothing_and_all_are_the_default():
    lattice = Lattice(shape=(5, 5, 5))
    assert not lattice.frozen(continuity=1, faces=()).any()
    every = lattice.frozen(continuity=0)
    expected = np.ones((5, 5, 5), bool)
    expected[1:-1, 1:-1, 1:-1] = False
    np.testing.assert_array_equal(every, expected)


@pytest.mark.parametrize(
    "control",
    [
        np.zeros((4, 4, 4)),
        np.zeros((4, 4, 3, 3)),
        np.full((4, 4, 4, 3), NAN),
        "rest",
        None,
        np.zeros((2, 2, 4, 4, 4, 3)),
    ],
    ids=lambda c: str(getattr(c, "shape", c)),
)
def test_control_points_to_refine(control):
    lattice = Lattice(shape=CUBE)
    with refused(LatticeError, "control"):
        lattice.refine(control, shape=(5, 5, 5))
    if np.ndim(control) != 6:
        with refused(LatticeError, "control"):
            lattice.derivative(np.zeros((1, 3)), control)


@pytest.mark.parametrize("shape", [(5, 5), (5, 5, 100), (5, 5, NAN), "555", (3, 5, 5), (4.5, 5, 5)], ids=repr)
def test_shapes_to_refine_to(shape):
    with refused(LatticeError, "shape"):
        Lattice(shape=CUBE).refine(REST, shape=shape)


@pytest.mark.parametrize("degree", [0, 2, 99, (4, 4), "high", NAN, (4, 4, 2)], ids=repr)
def test_degrees_to_refine_to(degree):
    with refused(LatticeError, ("degree", "control points")):
        Lattice(shape=CUBE).refine(REST, degree=degree)


@pytest.mark.parametrize(
    "insert",
    [([0.5], [0.5]), ([0.5],) * 4, 0.5, "knots", ([1.5], None, None), ([-0.1], None, None), ([INF], None, None)],
    ids=repr,
)
def test_knots_to_insert(insert):
    lattice = Lattice(shape=(6, 6, 6), basis="bspline", degree=3)
    with refused(LatticeError, ("insert", "knot")):
        lattice.refine(lattice.rest, insert=insert)


def test_blenders_basis_cannot_be_refined_without_a_change():
    with refused(LatticeError, "blender"):
        lattice = Lattice(shape=CUBE, basis="blender")
        lattice.refine(lattice.rest, shape=(5, 5, 5))


@pytest.mark.parametrize("parameters", [np.ones((4, 2)), np.ones(3), [[0, 0, NAN]], "x", None], ids=repr)
def test_derivative_at_bad_parameters(parameters):
    with refused(isochor.Error):
        Lattice(shape=CUBE).derivative(parameters, REST)


@pytest.mark.parametrize(
    ("sets", "weights"),
    [
        (REST, [1.0]),
        (REST[None], [1.0, 2.0]),
        (REST[None], [[1.0]]),
        (REST[None], [NAN]),
        (REST[None], "one"),
        (np.full((1, 4, 4, 4, 3), INF), [1.0]),
        (np.zeros((1, 4, 4, 5, 3)), [1.0]),
        (None, [1.0]),
    ],
)
def test_blends(sets, weights):
    with refused(LatticeError, ("set", "weight", "control")):
        Lattice(shape=CUBE).blend(sets, weights)


ROWS = ([0, 1, 2], [0, 1], [1.0, 1.0])


@pytest.mark.parametrize(
    ("offsets", "columns", "weights"),
    [
        ([0, 1, 3], *ROWS[1:]),
        ([1, 1, 2], *ROWS[1:]),
        ([0, 2, 1, 2], *ROWS[1:]),
        ([], *ROWS[1:]),
        ([0, 1.5, 2], *ROWS[1:]),
        ([0, 1, 2], [0, -1], [1.0, 1.0]),
        ([0, 1, 2], [0], [1.0, 1.0]),
        ([0, 1, 1, 2], [0, 1], [1.0, 1.0]),
        ([0, 1, 2], [0, 1], [1.0, NAN]),
        ([0, 1, 2], [0, 1], [1.0, INF]),
        ([0, 1, 2], [0, 1], [[1.0, 1.0]]),
        ([0, 1, 2], [0.5, 1], [1.0, 1.0]),
        ("rows", *ROWS[1:]),
        (None, None, None),
    ],
)
def test_surface_rows(offsets, columns, weights):
    with refused(MeshError):
        isochor.Surface(offsets, columns, weights)


def test_a_surface_fits_its_points():
    surface = isochor.Surface(*ROWS, point_count=2)
    for points in (np.ones((3, 3)), np.ones(2), np.ones((2, 2, 2)), "points", None):
        with refused(isochor.Error):
            surface.apply(points)
    with refused(MeshError, ("column", "point"), 7):
        isochor.Surface([0, 1], [7], [1.0], point_count=3)
    with refused(MeshError, ("point", "surface")):
        Lattice(shape=CUBE).bind(np.random.default_rng(0).random((5, 3)), [[0, 1, 0]], surface=surface)
    for wrong in (3, "surface", ROWS):
        with refused(isochor.Error, "surface"):
            Lattice(shape=CUBE).bind(np.ones((2, 3)), None, surface=wrong)


def test_triangles_index_the_surface():
    count = len(BALL[0])
    surface = isochor.Surface(np.arange(count + 1), np.arange(count), np.ones(count))
    wrong = BALL[1].copy()
    wrong[3, 1] = count
    with refused(MeshError, count):
        Lattice(shape=CUBE).bind(BALL[0], wrong, surface=surface)
    binding = Lattice(shape=CUBE).bind(BALL[0], meshes.opened(BALL)[1], surface=surface)
    with refused(MeshError):
        binding.preserve(REST)


@pytest.mark.parametrize(
    ("points", "patches"),
    [
        (np.ones((16, 2)), np.arange(16).reshape(1, 4, 4)),
        (np.full((16, 3), NAN), np.arange(16).reshape(1, 4, 4)),
        (np.ones((15, 3)), np.arange(16).reshape(1, 4, 4)),
        (np.ones((16, 3)), -np.arange(16).reshape(1, 4, 4)),
        (np.ones((16, 3)), np.arange(16).reshape(4, 4)),
        (np.ones((16, 3)), np.arange(16).reshape(1, 4, 4) + 0.5),
        (np.ones((16, 3)), np.arange(16).reshape(1, 16, 1)),
        ("points", np.arange(16).reshape(1, 4, 4)),
        (None, None),
    ],
)
def test_patches(points, patches):
    with refused(MeshError):
        isochor.Patches(points, patches)


@pytest.mark.parametrize("level", [0, -1, 1.5, "fine", NAN, None, 10**6], ids=repr)
def test_levels_of_patches(level):
    grid = np.random.default_rng(0).random((16, 3))
    with refused(isochor.Error, "level"):
        isochor.Patches(grid, np.arange(16).reshape(1, 4, 4)).tessellate(level)


def test_places_on_patches():
    patches = isochor.Patches(np.random.default_rng(0).random((16, 3)), np.arange(16).reshape(1, 4, 4))
    for number in (1, -1, "first", None, 0.5):
        with refused(isochor.Error, "patch"):
            patches.evaluate(number, [[0.5, 0.5]])
    for uv in ([[0.5]], [0.5, 0.5], [[NAN, 0.5]], "uv", None):
        with refused(isochor.Error):
            patches.evaluate(0, uv)


@pytest.mark.parametrize("tolerance", [0, -1e-3, NAN, INF, "fine", None], ids=repr)
def test_tolerances(tolerance):
    with refused(isochor.Error, "tolerance"):
        isochor.tessellate(Lattice(shape=CUBE), *BALL, REST, tolerance)
    with refused(isochor.Error, "tolerance"):
        isochor.bent_edges(Lattice(shape=CUBE), BALL[0], BALL[1][:, :2], REST, tolerance)


@pytest.mark.parametrize("levels", [-1, 1.5, "many", NAN, 100], ids=repr)
def test_levels_of_tessellation(levels):
    with refused(isochor.Error, "level"):
        isochor.tessellate(Lattice(shape=CUBE), *BALL, REST, 1e-3, levels=levels)


def test_what_is_tessellated():
    lattice = Lattice(shape=CUBE)
    vertices, triangles = BALL
    for bad in (vertices[:, :2], np.full_like(vertices, NAN), None, "mesh"):
        with refused(MeshError):
            isochor.tessellate(lattice, bad, triangles, REST, 1e-3)
    for bad in (triangles + len(vertices), -triangles - 1, triangles + 0.5, None, "faces"):
        with refused(MeshError):
            isochor.tessellate(lattice, vertices, bad, REST, 1e-3)
    with refused(LatticeError, "control"):
        isochor.tessellate(lattice, vertices, triangles, REST[:2], 1e-3)
    for bad in ([[0, len(vertices)]], [[0, 1, 2]], [[0.5, 1]], None):
        with refused(isochor.Error, "edge"):
            isochor.bent_edges(lattice, vertices, bad, REST, 1e-3)
    with refused(isochor.Error, "outside"):
        isochor.tessellate(lattice, vertices, triangles, REST, 1e-3, outside="ignore")


def test_chains():
    lattice, other = Lattice(shape=CUBE), Lattice(shape=(3, 3, 3))
    for links in (
        [],
        None,
        3,
        lattice,
        [(lattice,)],
        [(lattice, 3)],
        [("lattice", {})],
        [(lattice, {"triangels": 1})],
    ):
        with refused(isochor.Error):
            isochor.Chain(links, *BALL)
    chain = isochor.Chain([(lattice, {}), (other, {})], *BALL)
    for controls in (
        [REST],
        [REST, other.rest, REST],
        REST,
        None,
        [other.rest, REST],
        [REST, np.full_like(other.rest, NAN)],
    ):
        with refused(isochor.Error, ("control", "lattice")):
            chain.deform(controls)
        with refused(isochor.Error, ("control", "lattice")):
            chain.preserve(controls)
    with refused(MeshError):
        isochor.Chain([(lattice, {})], BALL[0], BALL[1] + len(BALL[0]))
    open_chain = isochor.Chain([(lattice, {"outside": "extend"})], *meshes.opened(BALL))
    open_chain.deform([REST])
    with refused(MeshError):
        open_chain.preserve([REST])


def test_ties_of_wrong_control_points():
    a = Lattice(shape=CUBE)
    b = Lattice(shape=(5, 4, 4), origin=(1, 0, 0))
    tie = isochor.Tie(a, "s1", b, "s0")
    for leader, follower in (
        (REST[:2], b.rest),
        (REST, REST),
        (np.full_like(REST, NAN), b.rest),
        (None, b.rest),
        (REST, "b"),
    ):
        with refused(LatticeError, "control"):
            tie.apply(leader, follower)
    for leader in ("c", None, 0):
        with refused(isochor.Error, "leader"):
            tie.apply(REST, b.rest, leader=leader)
    with refused(isochor.Error):
        isochor.Tie(a, "s1", "b", "s0")
    with refused(LatticeError):
        isochor.Tie(a, "s1", Lattice(shape=(5, 5, 4), origin=(1, 0, 0)), "s0")


@pytest.mark.parametrize(
    "given",
    [
        {"shape": (4, 4, 4)},
        {"shape": (0, 4)},
        {"shape": "44"},
        {"shape": (4, 4), "origin": (0, 0, 0)},
        {"shape": (4, 4), "origin": (0, NAN)},
        {"shape": (4, 4), "edges": np.eye(3)},
        {"shape": (4, 4), "edges": ((1, 0), (2, 0))},
        {"shape": (4, 4), "weights": np.ones((4, 5))},
        {"shape": (4, 4), "weights": -np.ones((4, 4))},
        {"shape": (4, 4), "basis": "bezier"},
        {"shape": (4, 4), "basis": "bspline", "degree": (3, 3, 3)},
        {"shape": (4, 4), "basis": "bspline", "knots": "open"},
    ],
    ids=repr,
)
def test_lattices_of_the_plane(given):
    with refused(LatticeError):
        isochor.Lattice2D(**given)


def test_what_is_bound_in_the_plane():
    lattice = isochor.Lattice2D(shape=(4, 4))
    square = np.array([[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]])
    for points in (np.ones((4, 3)), np.ones(2), [[0, NAN]], "points", None):
        with refused(MeshError):
            lattice.bind(points)
    for triangles in ([[0, 1, 4]], [[0, 1]], [[0, 1, 1.5]], "faces"):
        with refused(MeshError):
            lattice.bind(square, triangles)
    binding = lattice.bind(square, [[0, 1, 2], [0, 2, 3]])
    for control in (np.zeros((4, 4, 3)), np.zeros((4, 4)), np.full((4, 4, 2), NAN), None):
        with refused(LatticeError, "control"):
            binding.deform(control)
        with refused(LatticeError, "control"):
            binding.preserve(control)
    for axes in ((0, 0), (1, -1), (1, 1, 1), (NAN, 1), "xy"):
        with refused(isochor.Error, "axes"):
            binding.preserve(lattice.rest, axes=axes)
    flat = lattice.rest * [1, 0]
    with refused(isochor.VolumeError):
        binding.preserve(flat, axes=(1, 0))
    with refused(isochor.Error):
        lattice.bind(square).preserve(lattice.rest)
