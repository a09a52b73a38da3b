# SPDX-License-Identifier: GPL-3.0-or-later
"""The promise: whatever the lattice, the deformation and the shares, the volume is reached to rounding."""

from functools import cache

import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Embedded
from promised import DTYPES, PLANNED, SHARES, SPECS


def ball(dtype) -> tuple[np.ndarray, np.ndarray]:
    vertices, triangles = meshes.bumpy_ball(3, 0.15)
    return vertices.astype(dtype), triangles


@cache
def bound(name: str, dtype_name: str):
    """Binding and oracle of the ball in the named lattice."""
    vertices, triangles = ball(DTYPES[dtype_name])
    return SPECS[name].build().bind(vertices, triangles, device="cpu"), Embedded.of(SPECS[name], vertices, triangles)


@cache
def planned(name: str, kind: str, ratio: float) -> np.ndarray:
    return lattices.to_ratio(bound(name, "float64")[1], kind, ratio)


def check(result, embedded: Embedded, control, target: float):
    """The volume measured here on result.vertices; result's own figures; vertices are those of result.control."""
    room = oracle.tolerance(result.vertices, embedded.triangles, embedded.spec.centre, target)
    found = oracle.volume(result.vertices, embedded.triangles, embedded.spec.centre)
    assert abs(found - target) / abs(target) <= room
    assert result.target == pytest.approx(target, rel=max(1e-12, room))
    assert abs(result.error - abs(found - result.target) / abs(result.target)) <= room / 2
    assert result.volume == pytest.approx(found, rel=room / 2)
    epsilon = float(np.finfo(result.vertices.dtype).eps)
    atol = embedded.spec.rounding(np.abs(result.control).max() + np.abs(embedded.spec.rest).max(), epsilon)
    np.testing.assert_allclose(result.vertices, embedded.deform(result.control), rtol=0, atol=atol)
    assert result.control.dtype == np.float64
    assert result.control.shape == np.shape(control)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize("shares", SHARES, ids=str)
@pytest.mark.parametrize(("kind", "ratio"), PLANNED)
@pytest.mark.parametrize("name", SPECS)
def test_volume_is_reached(name, kind, ratio, shares, method, dtype):
    binding, embedded = bound(name, dtype)
    control = planned(name, kind, ratio)
    reference = oracle.volume(*ball(DTYPES[dtype]), SPECS[name].centre)
    assert embedded.volume(control) / reference == pytest.approx(ratio, rel=1e-4)
    result = binding.preserve(control, axes=shares, method=method)
    check(result, embedded, control, reference)
    assert result.method == method
    assert result.vertices.dtype == DTYPES[dtype]
    still = np.array(shares) == 0
    np.testing.assert_array_equal(result.control[..., still], control[..., still])
    assert not np.array_equal(result.control[..., ~still], control[..., ~still])


@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize("shares", SHARES, ids=str)
@pytest.mark.parametrize(("kind", "ratio"), [("squash", 0.36), ("twist", 0.34), ("dent", 0.6), ("spread", 4.0)])
@pytest.mark.parametrize("name", SPECS)
def test_displacements_are_those_of_the_closed_form(name, kind, ratio, shares, method):
    binding, embedded = bound(name, "float64")
    control = planned(name, kind, ratio)
    target = embedded.volume(embedded.spec.rest)
    expected = getattr(embedded, method)(control, shares, target) - control
    found = binding.preserve(control, axes=shares, method=method).control - control
    assert np.linalg.norm(found - expected) <= 1e-9 * np.linalg.norm(expected)


@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize("mesh", ["torus", "box", "islands", "tiny-beside-huge", "inside-out"])
@pytest.mark.parametrize("dtype", DTYPES)
def test_other_surfaces(mesh, method, dtype):
    vertices, triangles = {
        "torus": meshes.torus,
        "box": meshes.box,
        "islands": meshes.two_islands,
        "tiny-beside-huge": meshes.tiny_beside_huge,
        "inside-out": lambda: meshes.inside_out(meshes.bumpy_ball()),
    }[mesh]()
    vertices = vertices.astype(DTYPES[dtype])
    spec = SPECS["uniform-6"]
    control = lattices.noisy(spec, 0.1) * [1.2, 0.9, 0.4]
    result = spec.build().bind(vertices, triangles).preserve(control, axes=(1, 1, 0), method=method)
    target = oracle.volume(vertices, triangles, spec.centre)
    check(result, Embedded.of(spec, vertices, triangles), control, target)


@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize("name", lattices.FRAMES)
def test_any_frame_of_the_lattice(name, method):
    spec = lattices.FRAMES[name]
    vertices, triangles = meshes.bumpy_ball()
    vertices = lattices.fitted(spec, vertices)
    embedded = Embedded.of(spec, vertices, triangles)
    control = spec.centre + (lattices.noisy(spec, 0.1) - spec.centre) * [1, 1, 0.5]
    result = spec.build().bind(vertices, triangles).preserve(control, method=method)
    check(result, embedded, control, oracle.volume(vertices, triangles, spec.centre))


@pytest.mark.parametrize("name", lattices.THIN)
def test_lattices_with_one_point_on_an_axis(name):
    """Thin lattices move points by displacements; squeezed in x, y and z as far as they can, they still preserve."""
    spec = lattices.THIN[name]
    lattice, (vertices, triangles) = spec.build(), meshes.bumpy_ball()
    binding = lattice.bind(vertices, triangles)
    control = lattice.rest + 0.1 * np.square(lattice.rest - spec.centre)[..., ::-1] - [0, 0.02, 0]
    if name == "point":
        check_rigid(binding, control)
        return
    result = binding.preserve(control, method="sweep")
    target = oracle.volume(vertices, triangles, spec.centre)
    room = oracle.tolerance(result.vertices, triangles, spec.centre, target)
    assert oracle.volume(result.vertices, triangles, spec.centre) == pytest.approx(target, rel=room)
    np.testing.assert_allclose(
        result.vertices, binding.deform(result.control), rtol=0, atol=1e-13 * max(1, np.abs(result.control).max())
    )


def check_rigid(binding, control):
    """A lattice of one point can only carry the mesh along: the volume is kept already and nothing is to do."""
    result = binding.preserve(control)
    assert result.volume == pytest.approx(binding.reference_volume, rel=1e-12)
    np.testing.assert_allclose(result.control, control, rtol=0, atol=1e-12)


def test_rest_needs_no_correction():
    for spec in SPECS.values():
        result = spec.build().bind(*meshes.bumpy_ball()).preserve(spec.rest)
        np.testing.assert_allclose(result.control, spec.rest, rtol=0, atol=1e-13)


def test_a_mesh_a_million_units_away():
    """Positions there are known to 1.2e-10, so the volume is to about 4 ε A R / |V| with R = 1e6."""
    offset = np.array([1e6, 1e6, -1e6])
    for name in ("bernstein-4", "uniform-10"):
        spec = SPECS[name].moved(offset=offset)
        vertices, triangles = meshes.bumpy_ball()
        binding = spec.build().bind(vertices + offset, triangles)
        control = spec.centre + (spec.rest - spec.centre) * [1.1, 1, 0.36]
        result = binding.preserve(control, axes=(1, 1, 0))
        found = oracle.volume(result.vertices, triangles, spec.centre)
        target = oracle.volume(vertices + offset, triangles, spec.centre)
        room = 4 * 2.3e-16 * oracle.area(result.vertices, triangles) * 1e6 / target
        assert abs(found - target) / target <= room < 2e-8
        near = SPECS[name].build().bind(vertices, triangles)
        expected = near.preserve(control - offset, axes=(1, 1, 0)).control
        np.testing.assert_allclose(result.control - offset, expected, rtol=0, atol=1e-8)
