# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as they come: dtypes, strides, orders, read-only ones, and whose memory is whose."""

import isochor
import lattices
import meshes
import numpy as np
import pytest
from oracle import Spec

SPEC = Spec((5, 4, 6), "bspline", 3, "clamped")
VERTICES, TRIANGLES = meshes.bumpy_ball(2)
CONTROL = lattices.noisy(SPEC, 0.1)


def strided(array):
    """The same numbers, every second entry of a larger array along each axis."""
    wide = np.full([2 * n for n in array.shape], 77, array.dtype)
    view = wide[tuple(slice(None, None, 2) for _ in array.shape)]
    view[...] = array
    assert not view.flags.c_contiguous
    return view


LAYOUTS = {
    "fortran": np.asfortranarray,
    "strided": strided,
    "reversed": lambda array: np.ascontiguousarray(array[::-1])[::-1],
    "transposed": lambda array: np.ascontiguousarray(array.T).T,
    "offset": lambda array: np.concatenate([array[:1], array])[1:],
}


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def unaligned(array):
    raw = np.zeros(array.nbytes + 1, np.uint8)
    view = raw[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    assert not view.flags.aligned
    return view


LAYOUTS |= {"read-only": read_only, "unaligned": unaligned}


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_any_memory_layout_gives_the_same_bits(layout, dtype):
    vertices, weights = VERTICES.astype(dtype), np.random.default_rng(0).uniform(1, 5, SPEC.shape)
    influence = np.linspace(0.1, 1, len(vertices))
    plain = SPEC.build().bind(vertices, TRIANGLES, influence=influence)
    other = SPEC.build().bind(layout(vertices), layout(TRIANGLES), influence=layout(influence))
    np.testing.assert_array_equal(other.deform(layout(CONTROL)), plain.deform(CONTROL))
    assert other.volume(layout(CONTROL)) == plain.volume(CONTROL)
    frame = lattices.rotation()
    ours = other.preserve(layout(CONTROL), weights=layout(weights), frame=layout(frame))
    theirs = plain.preserve(CONTROL, weights=weights, frame=frame)
    np.testing.assert_array_equal(ours.control, theirs.control)
    np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    other.update(layout(vertices))
    np.testing.assert_array_equal(other.deform(CONTROL), plain.deform(CONTROL))
    lattice = SPEC.build()
    np.testing.assert_array_equal(lattice.parameters(layout(vertices)), lattice.parameters(vertices))
    parameters = lattice.parameters(VERTICES)
    np.testing.assert_array_equal(
        lattice.evaluate(layout(parameters), layout(CONTROL)), lattice.evaluate(parameters, CONTROL)
    )


@pytest.mark.parametrize("dtype", [np.int32, np.int64, np.uint32, np.uint64, np.int16, np.uint16, np.intp, np.uint8])
def test_triangles_of_any_integer_dtype(dtype):
    triangles = TRIANGLES.astype(dtype)
    assert np.array_equal(triangles, TRIANGLES)
    binding = SPEC.build().bind(VERTICES, triangles)
    assert binding.reference_volume == SPEC.build().bind(VERTICES, TRIANGLES).reference_volume


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_vertices_come_back_in_their_dtype(dtype):
    binding = SPEC.build().bind(VERTICES.astype(dtype), TRIANGLES)
    result = binding.preserve(CONTROL)
    for out in (binding.deform(CONTROL), result.vertices):
        assert out.dtype == dtype
        assert out.shape == VERTICES.shape
        assert out.flags.c_contiguous
    assert result.control.dtype == np.float64


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble], ids=lambda d: d.__name__)
def test_control_points_of_any_float_dtype(dtype):
    control = CONTROL.astype(dtype)
    binding = SPEC.build().bind(VERTICES, TRIANGLES)
    np.testing.assert_array_equal(binding.deform(control), binding.deform(control.astype(np.float64)))
    result = binding.preserve(control)
    np.testing.assert_array_equal(result.control, binding.preserve(control.astype(np.float64)).control)


def test_float32_and_float64_agree_to_float32():
    double = SPEC.build().bind(VERTICES, TRIANGLES).preserve(CONTROL)
    single = SPEC.build().bind(VERTICES.astype(np.float32), TRIANGLES).preserve(CONTROL)
    np.testing.assert_allclose(single.vertices, double.vertices, rtol=0, atol=SPEC.rounding(CONTROL, 1.2e-7))
    np.testing.assert_allclose(single.control, double.control, rtol=0, atol=2e-5)


@pytest.mark.parametrize("name", ["vertices", "triangles", "control"])
def test_foreign_byte_order_is_understood_or_refused(name):
    """Never a wrong picture: the right numbers, or an exception of ours."""
    arrays = {"vertices": VERTICES, "triangles": TRIANGLES, "control": CONTROL}
    expected = SPEC.build().bind(VERTICES, TRIANGLES).preserve(CONTROL).vertices
    arrays[name] = arrays[name].astype(arrays[name].dtype.newbyteorder())
    try:
        out = SPEC.build().bind(arrays["vertices"], arrays["triangles"]).preserve(arrays["control"]).vertices
    except isochor.Error:
        return
    np.testing.assert_array_equal(out, expected)


def test_nothing_handed_in_is_changed():
    arrays = [VERTICES.copy(), TRIANGLES.copy(), CONTROL.copy(), np.linspace(0.5, 1, len(VERTICES))]
    weights = np.full(SPEC.shape, 2.0)
    kept = [array.copy() for array in (*arrays, weights)]
    binding = SPEC.build().bind(arrays[0], arrays[1], influence=arrays[3])
    binding.preserve(arrays[2], weights=weights)
    binding.deform(arrays[2])
    binding.update(arrays[0])
    for array, before in zip((*arrays, weights), kept):
        np.testing.assert_array_equal(array, before)


def test_a_binding_keeps_its_own_copy():
    vertices, triangles = VERTICES.copy(), TRIANGLES.copy()
    influence = np.linspace(0.5, 1, len(vertices))
    binding = SPEC.build().bind(vertices, triangles, influence=influence)
    before = binding.preserve(CONTROL)
    vertices[:] = 9e9
    triangles[:] = 0
    influence[:] = 0
    after = binding.preserve(CONTROL)
    np.testing.assert_array_equal(after.vertices, before.vertices)


def test_results_are_the_callers():
    """Writing into what was returned must not reach the library's state or another result."""
    lattice = SPEC.build()
    binding = lattice.bind(VERTICES, TRIANGLES)
    first = binding.deform(CONTROL)
    kept = first.copy()
    first[:] = 0
    np.testing.assert_array_equal(binding.deform(CONTROL), kept)
    rest = lattice.rest
    if rest.flags.writeable:
        rest[:] = 0
    np.testing.assert_allclose(lattice.rest, SPEC.rest, atol=1e-15)


def test_a_binding_outlives_its_lattice():
    binding = SPEC.build().bind(VERTICES.copy(), TRIANGLES.copy())
    expected = SPEC.build().bind(VERTICES, TRIANGLES).deform(CONTROL)
    np.testing.assert_array_equal(binding.deform(CONTROL), expected)


def test_tuples_and_lists_where_the_api_shows_them():
    lattice = isochor.Lattice(shape=[4, 4, 4], origin=[0, 0, 0], edges=[[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    binding = lattice.bind(VERTICES, TRIANGLES)
    listed = binding.preserve(lattice.rest * [1, 1, 0.5], axes=[1, 1, 0], frame=[[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    arrays = binding.preserve(lattice.rest * [1, 1, 0.5], axes=np.array([1.0, 1, 0]), frame=np.eye(3))
    np.testing.assert_array_equal(listed.control, arrays.control)
