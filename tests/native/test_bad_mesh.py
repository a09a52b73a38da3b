# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that cannot be deformed, or whose volume has no meaning, are refused with the first offender and the count."""

import isochor
import meshes
import numpy as np
import pytest
from isochor import MeshError
from refusals import refused

NAN, INF = float("nan"), float("inf")
LATTICE = isochor.Lattice(shape=(4, 4, 4))
REST = LATTICE.rest
GOOD = meshes.icosphere(1)  # 42 vertices, 80 triangles


def changed(array, **entries):
    """A copy with entries replaced: changed(v, at_7=(nan, 0, 0))."""
    array = np.array(array)
    for name, value in entries.items():
        array[int(name.removeprefix("at_"))] = value
    return array


@pytest.mark.parametrize("bad", [NAN, INF, -INF])
@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
def test_vertices_that_are_not_finite_are_counted_and_the_first_is_named(bad, dtype):
    vertices = changed(GOOD[0], at_7=(0.5, bad, 0.5), at_11=(0.5, 0.5, bad), at_30=(bad, bad, bad)).astype(dtype)
    for triangles in (GOOD[1], None):
        with refused(MeshError, "vert", 7, 3):
            LATTICE.bind(vertices, triangles)
    binding = LATTICE.bind(GOOD[0].astype(dtype), GOOD[1])
    with refused(MeshError, "vert", 7, 3):
        binding.update(vertices)


@pytest.mark.parametrize(("index", "found"), [(42, 42), (999, 999), (-1, "-1"), (2**31 - 1, 2**31 - 1)])
def test_indices_out_of_range_are_counted_and_the_first_is_named(index, found):
    triangles = changed(GOOD[1], at_5=(0, 1, index), at_17=(index, 1, 2))
    with refused(MeshError, "triangle", 5, found, 2):
        LATTICE.bind(GOOD[0], triangles)


@pytest.mark.parametrize("dtype", [np.int64, np.uint64, np.uint32])
def test_indices_beyond_32_bits_are_not_wrapped_around(dtype):
    triangles = GOOD[1].astype(dtype)
    right = int(triangles[5, 2])
    largest = int(np.iinfo(dtype).max)
    for index in {right + 2**32, largest, largest - 2**32 + 1 + right, 2**31} - {right}:
        if index <= largest:
            triangles[5, 2] = index
            with refused(MeshError, "triangle", 5):
                LATTICE.bind(GOOD[0], triangles)


VOLUMES = {
    "volume": lambda binding: binding.volume(REST),
    "reference_volume": lambda binding: binding.reference_volume,
    "preserve": lambda binding: binding.preserve(REST),
}
each_volume = pytest.mark.parametrize("ask", VOLUMES.values(), ids=VOLUMES)


@each_volume
def test_open_meshes_deform_but_have_no_volume(ask):
    mesh = meshes.opened(GOOD, 12)
    binding = LATTICE.bind(*mesh)
    np.testing.assert_allclose(binding.deform(REST), mesh[0], atol=1e-14)
    with refused(MeshError, ("open", "boundary", "closed"), 3, tuple(int(v) for v in GOOD[1][12])):
        ask(binding)


@each_volume
def test_edges_of_three_triangles(ask):
    binding = LATTICE.bind(*meshes.with_fin(GOOD))
    with refused(MeshError, "edge"):
        ask(binding)


@each_volume
def test_an_edge_of_four_triangles_is_not_a_manifold(ask):
    binding = LATTICE.bind(*meshes.sharing_an_edge())
    with refused(MeshError, "manifold", "edge", 0, 3):
        ask(binding)


@each_volume
@pytest.mark.parametrize("triangle", [0, 33])
def test_one_triangle_wound_the_wrong_way(ask, triangle):
    binding = LATTICE.bind(*meshes.one_flipped(GOOD, triangle))
    with refused(MeshError, ("wound", "winding", "orient"), "edge", 3):
        ask(binding)


@each_volume
def test_an_island_wound_the_other_way_is_consistent(ask):
    """Every edge is used once each way: a hollow, and no error."""
    mesh = meshes.joined(meshes.icosphere(2, 0.4), meshes.inside_out(meshes.icosphere(2, 0.2)))
    ask(LATTICE.bind(*mesh))


@each_volume
def test_points_without_triangles_have_no_volume(ask):
    with refused(MeshError, "triangle"):
        ask(LATTICE.bind(GOOD[0]))


@each_volume
def test_a_mesh_without_triangles_has_no_volume(ask):
    with refused(MeshError):
        ask(LATTICE.bind(GOOD[0], np.zeros((0, 3), np.int32)))


def test_an_empty_mesh():
    empty, none = np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    with refused(MeshError):
        LATTICE.bind(empty, none).preserve(REST)
    with refused(MeshError):
        LATTICE.bind(empty).volume(REST)


@pytest.mark.parametrize(
    "vertices",
    [
        np.ones((42, 2)),
        np.ones((42, 4)),
        np.ones(126),
        np.ones((42, 3, 1)),
        np.ones((42, 3), int),
        np.ones((42, 3), complex),
        np.ones((42, 3), bool),
        np.ones((42, 3), np.float16),
        np.full((42, 3), "x"),
        np.full((42, 3), None),
        "vertices",
        None,
        3.0,
        object(),
    ],
    ids=lambda v: f"{getattr(v, 'shape', type(v).__name__)}{getattr(v, 'dtype', '')}",
)
def test_vertices_of_the_wrong_kind(vertices):
    with refused(MeshError, "vert"):
        LATTICE.bind(vertices, GOOD[1])
    if vertices is not None:  # update(None) keeps the vertices
        with refused(MeshError, "vert"):
            LATTICE.bind(*GOOD).update(vertices)


def test_the_shape_of_vertices_found_and_expected_is_said():
    with refused(MeshError, 42, 2, 3):
        LATTICE.bind(np.ones((42, 2)))


@pytest.mark.parametrize("count", [0, 41, 43, 1000])
def test_update_with_another_number_of_vertices(count):
    binding = LATTICE.bind(*GOOD)
    with refused(MeshError, "vert", 42, count):
        binding.update(np.ones((count, 3)))


def test_a_refused_update_changes_nothing():
    binding = LATTICE.bind(*GOOD)
    for bad in (np.ones((41, 3)), changed(GOOD[0] + 0.1, at_41=(NAN, 0, 0))):
        with refused(MeshError):
            binding.update(bad)
    np.testing.assert_array_equal(binding.deform(REST), LATTICE.bind(*GOOD).deform(REST))
    assert binding.reference_volume == LATTICE.bind(*GOOD).reference_volume


@pytest.mark.parametrize(
    "triangles",
    [
        GOOD[1].astype(float),
        GOOD[1].astype(complex),
        GOOD[1] > 3,
        GOOD[1][:, :2],
        np.concatenate([GOOD[1], GOOD[1][:, :1]], axis=1),
        GOOD[1].ravel(),
        GOOD[1][None],
        GOOD[1].astype(str),
        GOOD[1].astype(object),
        "triangles",
        7,
        object(),
    ],
    ids=lambda t: f"{getattr(t, 'shape', type(t).__name__)}{getattr(t, 'dtype', '')}",
)
def test_triangles_of_the_wrong_kind(triangles):
    with refused(MeshError, "triangle"):
        LATTICE.bind(GOOD[0], triangles)


@pytest.mark.parametrize("outside", ["freeze", "", None, 1], ids=repr)
def test_unknown_outside_lists_the_choices(outside):
    with refused(isochor.Error, "outside", "keep", "extend"):
        LATTICE.bind(*GOOD, outside=outside)


@pytest.mark.parametrize("device", ["cuda", "", None, 1], ids=repr)
def test_unknown_device_lists_the_choices(device):
    with refused(isochor.Error, "device", "auto", "cpu", "gpu"):
        LATTICE.bind(*GOOD, device=device)


def test_a_gpu_where_there_is_none_is_a_warning_and_the_cpu_computes():
    if {device.kind for device in isochor.devices()} & {"gpu", "software"}:
        assert LATTICE.bind(*GOOD, device="gpu").preserve(REST, target=0.4).error < 1e-6
        return
    with pytest.warns(RuntimeWarning, match="(?i)gpu"):
        binding = LATTICE.bind(*GOOD, device="gpu")
    assert binding.preserve(REST, target=0.4).device == "cpu"


@pytest.mark.parametrize(
    ("influence", "said"),
    [
        (np.ones(41), (41, 42)),
        (np.ones((42, 1)), (42,)),
        (np.float64(0.5), ()),
        (changed(np.ones(42), at_9=1.5, at_20=2.0), (9, 2)),
        (changed(np.ones(42), at_9=-0.25), (9,)),
        (changed(np.ones(42), at_9=NAN, at_10=NAN, at_11=INF), (9, 3)),
        (np.ones(42, complex), ()),
        (np.full(42, "1"), ()),
        ("strong", ()),
    ],
    ids=["short", "column", "scalar", "above", "below", "nan", "complex", "strings", "string"],
)
def test_influence(influence, said):
    with refused(isochor.Error, "influence", *said):
        LATTICE.bind(*GOOD, influence=influence)
