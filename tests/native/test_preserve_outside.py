# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that sticks out of its lattice: with "keep", the correction must not tear it where it enters the domain."""

import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Spec

# layers of control points that decide where the domain's face lies: one if clamped, else the basis functions
# that are not zero there
SPECS = {
    "bernstein-5": (Spec((5, 5, 5)), 1),
    "clamped-7": (Spec((7, 7, 7), "bspline", 3, "clamped"), 1),
    "uniform-linear-7": (Spec((7, 7, 7), "bspline", 1, "uniform"), 1),
    "uniform-quadratic-8": (Spec((8, 8, 8), "bspline", 2, "uniform"), 2),
    "uniform-cubic-9": (Spec((9, 9, 9), "bspline", 3, "uniform"), 3),
}
each_spec = pytest.mark.parametrize(("spec", "layers"), SPECS.values(), ids=SPECS)
each_method = pytest.mark.parametrize("method", ["sweep", "balanced"])
each_side = pytest.mark.parametrize("side", [0, 1])
each_axis = pytest.mark.parametrize("axis", [0, 1, 2])


def sticking_out(axis: int, side: int):
    """A ball whose middle lies in the domain and that leaves it through one face only."""
    centre = np.full(3, 0.5)
    centre[axis] = 0.25 if side == 0 else 0.75
    return meshes.bumpy_ball(4, 0.1, centre=centre)


def dented(spec: Spec, axis: int, side: int, layers: int) -> np.ndarray:
    """Only control points far from the crossed face are moved: the plain deformation does not tear."""
    control = spec.rest.copy()
    inner = np.moveaxis(control, axis, 0) if side == 0 else np.moveaxis(control, axis, 0)[::-1]
    inner[max(layers, 1) :, ..., (axis + 1) % 3] = 0.5 + 0.6 * (inner[max(layers, 1) :, ..., (axis + 1) % 3] - 0.5)
    return control


def face_layers(control: np.ndarray, axis: int, side: int, layers: int) -> np.ndarray:
    ordered = np.moveaxis(control, axis, 0)
    return ordered[:layers] if side == 0 else ordered[len(ordered) - layers :]


@each_spec
@each_method
@each_axis
@each_side
def test_layers_at_a_crossed_face_do_not_move(spec, layers, method, axis, side):
    vertices, triangles = sticking_out(axis, side)
    parameters = spec.parameters(vertices)
    assert (parameters[:, axis] < 0).any() if side == 0 else (parameters[:, axis] > 1).any()
    control = dented(spec, axis, side, layers)
    lattice = spec.build()
    result = lattice.bind(vertices, triangles, outside="keep").preserve(control, method=method)
    np.testing.assert_array_equal(
        face_layers(result.control, axis, side, layers), face_layers(control, axis, side, layers)
    )
    target = oracle.volume(vertices, triangles, spec.centre)
    room = oracle.tolerance(result.vertices, triangles, spec.centre, target)
    assert oracle.volume(result.vertices, triangles, spec.centre) == pytest.approx(target, rel=room)
    outside = (parameters[:, axis] < 0) if side == 0 else (parameters[:, axis] > 1)
    np.testing.assert_array_equal(result.vertices[outside], vertices[outside])
    on_face = np.random.default_rng(0).random((50, 3))
    on_face[:, axis] = side
    stuck = lattice.evaluate(on_face, result.control)
    np.testing.assert_allclose(stuck, on_face, rtol=0, atol=1e-13)


@each_spec
@each_method
def test_a_mesh_that_leaves_over_a_corner(spec, layers, method):
    """Three faces are crossed, and the layers of all three stand still."""
    vertices, triangles = meshes.bumpy_ball(4, 0.1, centre=(0.3, 0.7, 0.3))
    control = lattices.noisy(spec, 0.02)
    result = spec.build().bind(vertices, triangles, outside="keep").preserve(control, method=method)
    for axis, side in enumerate((0, 1, 0)):
        np.testing.assert_array_equal(face_layers(result.control - control, axis, side, layers), 0)
    target = oracle.volume(vertices, triangles, spec.centre)
    room = oracle.tolerance(result.vertices, triangles, spec.centre, target)
    assert oracle.volume(result.vertices, triangles, spec.centre) == pytest.approx(target, rel=room)


@each_spec
@each_method
def test_extend_freezes_nothing_and_is_exact(spec, layers, method):
    vertices, triangles = sticking_out(2, 0)
    control = lattices.deformed(spec, "squash", 0.5)
    result = spec.build().bind(vertices, triangles, outside="extend").preserve(control, axes=(1, 1, 0), method=method)
    target = oracle.volume(vertices, triangles, spec.centre)
    room = oracle.tolerance(result.vertices, triangles, spec.centre, target)
    assert oracle.volume(result.vertices, triangles, spec.centre) == pytest.approx(target, rel=room)
    moved = np.abs(result.control - control).max(axis=(0, 1, 3))
    assert moved[:layers].min() > 0


def test_nothing_is_frozen_when_nothing_sticks_out():
    spec = SPECS["uniform-cubic-9"][0]
    control = lattices.deformed(spec, "squash", 0.5)
    results = [
        spec.build().bind(*meshes.icosphere(3), outside=outside).preserve(control) for outside in ("keep", "extend")
    ]
    np.testing.assert_allclose(results[0].control, results[1].control, rtol=0, atol=1e-13)


def test_a_lattice_too_small_to_join_says_so():
    """A uniform cubic lattice of four points inside a larger ball: every layer is at a crossed face."""
    spec = Spec((4, 4, 4), "bspline", 3, "uniform")
    binding = spec.build().bind(*meshes.icosphere(3, 0.7), outside="keep")
    with pytest.raises(isochor.VolumeError) as caught:
        binding.preserve(spec.rest, target=1.0)
    assert "layer" in str(caught.value).lower()


def test_nothing_to_do_is_no_error_where_nothing_may_move():
    """Wholly outside, or frozen, but the volume is kept already to rounding: there is nothing to refuse."""
    for centre in ((5, 5, 5), (-3.3, 0.1, 0.7), (0.5, 0.5, 4)):
        vertices, triangles = meshes.bumpy_ball(3, centre=centre)
        result = Spec().build().bind(vertices, triangles, outside="keep").preserve(lattices.noisy(Spec()))
        np.testing.assert_array_equal(result.vertices, vertices)
    frozen = Spec().build().bind(*meshes.bumpy_ball()).preserve(Spec().rest, weights=np.full((4, 4, 4), np.inf))
    np.testing.assert_array_equal(frozen.control, Spec().rest)


def test_keep_leaves_a_mesh_that_lies_wholly_outside():
    vertices, triangles = meshes.icosphere(3, centre=(5, 5, 5))
    result = Spec().build().bind(vertices, triangles, outside="keep").preserve(lattices.noisy(Spec()))
    np.testing.assert_array_equal(result.vertices, vertices)
    assert result.error <= 1e-12
