# SPDX-License-Identifier: GPL-3.0-or-later
"""Corrections from the control points alone (Binding.prepare) are those over the mesh, but for rounding."""

import time
from concurrent.futures import ThreadPoolExecutor

import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Spec

SPECS = {
    "bernstein-4": Spec((4, 4, 4)),
    "bernstein-3-5-4": Spec((3, 5, 4)),
    "uniform-5": Spec((5, 5, 5), "bspline", 3, "uniform"),
}


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient"])
@pytest.mark.parametrize(("dtype", "room"), [(np.float64, 1e-12), (np.float32, 1e-6)], ids=["float64", "float32"])
def test_prepared_and_not_prepared_give_the_same(spec, method, dtype, room):
    vertices, triangles = meshes.bumpy_ball()
    vertices = vertices.astype(dtype)
    direct, prepared = (spec.build().bind(vertices, triangles, device="cpu") for _ in range(2))
    assert prepared.prepare()
    assert prepared.tensor_bytes > 0
    assert direct.tensor_bytes == 0
    for control in (lattices.noisy(spec), spec.rest * [0.5, 0.9, 1.4]):
        expected, found = (binding.preserve(control, method=method) for binding in (direct, prepared))
        assert np.allclose(found.control, expected.control, rtol=0, atol=1e-10 if dtype == np.float64 else 1e-5)
        volume = oracle.volume(found.vertices, triangles)
        assert volume == pytest.approx(oracle.volume(vertices, triangles), rel=room)


def test_what_has_no_tensor_says_so():
    large = Spec((10, 10, 10), "bspline", 3, "clamped").build().bind(*meshes.bumpy_ball())
    assert not large.prepare()
    islands = Spec().build().bind(*meshes.two_islands(), bodies="islands")
    assert not islands.prepare()
    vertices, triangles = meshes.bumpy_ball()
    with pytest.raises(isochor.MeshError):
        Spec().build().bind(vertices, triangles[1:]).prepare()


def test_an_update_drops_it():
    vertices, triangles = meshes.bumpy_ball()
    binding = Spec().build().bind(vertices, triangles, outside="extend")
    binding.prepare()
    binding.update(vertices * 0.8)
    assert binding.tensor_bytes == 0
    volume = oracle.volume(binding.preserve(lattices.noisy(Spec())).vertices, triangles)
    assert volume == pytest.approx(0.8**3 * oracle.volume(vertices, triangles), rel=1e-12)


def test_several_threads_may_prepare_and_correct():
    spec = SPECS["uniform-5"]
    binding = spec.build().bind(*meshes.bumpy_ball(4), device="cpu")
    control = lattices.noisy(spec)
    expected = binding.preserve(control).control

    def work(turn: int) -> bool:
        if turn % 3 == 0:
            binding.prepare()
        return np.allclose(binding.preserve(control).control, expected, rtol=0, atol=1e-10)

    with ThreadPoolExecutor(6) as pool:
        assert all(pool.map(work, range(24)))


def test_it_comes_by_itself_unless_forbidden():
    mesh, control = meshes.bumpy_ball(5), lattices.noisy(Spec())
    binding = Spec().build().bind(*mesh, device="cpu")
    isochor.prepare_in_background(False)
    try:
        expected = binding.preserve(control).control
        for _ in range(300):
            assert np.array_equal(binding.preserve(control).control, expected)
        assert binding.tensor_bytes == 0
    finally:
        isochor.prepare_in_background(True)
    patience = time.monotonic() + 60
    while binding.tensor_bytes == 0 and time.monotonic() < patience:
        binding.preserve(control)
    assert binding.tensor_bytes > 0
    assert np.allclose(binding.preserve(control).control, expected, rtol=0, atol=1e-10)
