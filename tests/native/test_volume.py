# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed volume of the mesh as bound and under a deformed lattice."""

import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Embedded, Spec

MESHES = {
    "sphere": meshes.icosphere(3),
    "bumpy": meshes.bumpy_ball(),
    "torus": meshes.torus(),
    "box": meshes.box(),
    "islands": meshes.two_islands(),
    "tiny-beside-huge": meshes.tiny_beside_huge(),
    "tetrahedron": meshes.tetrahedron(),
    "inside-out": meshes.inside_out(meshes.bumpy_ball()),
}
SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "uniform-6": Spec((6, 6, 6), "bspline", 3, "uniform"),
    "clamped-10": Spec((10, 10, 10), "bspline", 3, "clamped"),
}
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])


@each_mesh
@each_dtype
def test_reference_volume(mesh, dtype):
    vertices, triangles = mesh[0].astype(dtype), mesh[1]
    found = Spec().build().bind(vertices, triangles).reference_volume
    assert isinstance(found, float)
    expected = oracle.volume(vertices, triangles)
    # the bound positions are exact, whatever their dtype: only the sum rounds
    room = oracle.tolerance(vertices.astype(float), triangles, Spec().centre, expected)
    assert found == pytest.approx(expected, rel=room)


@each_mesh
@each_dtype
@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_volume_of_a_deformed_mesh(mesh, dtype, spec):
    vertices, triangles = mesh[0].astype(dtype), mesh[1]
    control = lattices.noisy(spec)
    found = spec.build().bind(vertices, triangles).volume(control)
    embedded = Embedded.of(spec, vertices, triangles)
    expected = embedded.volume(control)
    room = oracle.tolerance(embedded.deform(control).astype(dtype), triangles, spec.centre, expected)
    assert found == pytest.approx(expected, rel=room)


@each_mesh
def test_volume_at_rest_is_the_reference_volume(mesh):
    binding = Spec().build().bind(*mesh)
    room = oracle.tolerance(*mesh, Spec().centre, binding.reference_volume)
    assert binding.volume(Spec().rest) == pytest.approx(binding.reference_volume, rel=room)


@each_mesh
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_affine_map_multiplies_the_volume_by_its_determinant(mesh, seed):
    linear, offset = lattices.affine(seed)
    binding = Spec().build().bind(*mesh)
    expected = np.linalg.det(linear) * oracle.volume(*mesh)
    assert binding.volume(Spec().rest @ linear.T + offset) == pytest.approx(expected, rel=1e-12)


def test_winding_changes_the_sign_and_nothing_else():
    mesh, control = meshes.bumpy_ball(), lattices.noisy(Spec())
    binding, flipped = Spec().build().bind(*mesh), Spec().build().bind(*meshes.inside_out(mesh))
    assert flipped.reference_volume == pytest.approx(-binding.reference_volume, rel=1e-15)
    assert flipped.volume(control) == pytest.approx(-binding.volume(control), rel=1e-13)


def test_a_mirrored_lattice_turns_the_volume_negative():
    binding = Spec().build().bind(*meshes.bumpy_ball())
    mirrored = Spec().rest * [1, 1, -1]
    assert binding.volume(mirrored) == pytest.approx(-binding.reference_volume, rel=1e-13)


def test_the_volume_does_not_depend_on_where_the_world_has_its_origin():
    """1e6 units away: the bound positions are exact, the deformed ones rounded to the spacing of float64 there."""
    offset = np.array([1e6, 1e6, -1e6])
    vertices, triangles = meshes.bumpy_ball()
    vertices = np.round(vertices * 2**30) / 2**30  # exact at both places
    control = np.round(lattices.noisy(Spec()) * 2**30) / 2**30
    here = Spec().build().bind(vertices, triangles)
    there = Spec().moved(offset=offset).build().bind(vertices + offset, triangles)
    assert there.reference_volume == pytest.approx(here.reference_volume, rel=1e-12)
    room = 4 * 2.3e-16 * oracle.area(here.deform(control), triangles) * 1e6 / here.volume(control)
    assert there.volume(control + offset) == pytest.approx(here.volume(control), rel=room)


def test_influence_and_outside_count_in_the_volume():
    spec, mesh = Spec(), meshes.icosphere(3, 0.7)
    influence = np.random.default_rng(0).random(len(mesh[0]))
    control = lattices.noisy(spec, 0.1)
    for options in ({"outside": "keep"}, {"outside": "extend"}, {"influence": influence}):
        expected = Embedded.of(spec, *mesh, **options).volume(control)
        assert spec.build().bind(*mesh, **options).volume(control) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("corner", [(0, 0, 0), (0.001, 0.999, 0.5)])
def test_many_triangles_sum_without_loss(corner):
    """82 thousand triangles: the sum must not lose digits with their number."""
    mesh = meshes.icosphere(6)
    spec = lattices.with_frame(Spec(), np.asarray(corner) - 0.5, np.eye(3) * 2)
    found = spec.build().bind(*mesh).reference_volume
    assert found == pytest.approx(oracle.volume(*mesh), rel=2e-15)
