# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing ball's correctness table on the GPU: 1e-6 relative volume with float32 vertices, whatever the lattice,
the shares and the loss, measured here in float64; and float64 vertices to the rounding of float64.
"""

from functools import cache

import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Embedded
from promised import DTYPES, PLANNED, SHARES, SPECS

VOLUME = 1e-6  # what float32 vertices are promised
SHAPE = 1e-5  # CPU and GPU apart, in lattice sizes: float32 steps of a correction, of which the largest move by about 1


@cache
def bound(name: str, dtype: str, device: str):
    vertices, triangles = meshes.bumpy_ball(3, 0.15)
    return SPECS[name].build().bind(vertices.astype(DTYPES[dtype]), triangles, device=device)


@cache
def planned(name: str, kind: str, ratio: float) -> np.ndarray:
    return lattices.to_ratio(Embedded.of(SPECS[name], *meshes.bumpy_ball(3, 0.15)), kind, ratio)


@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize("shares", SHARES, ids=str)
@pytest.mark.parametrize(("kind", "ratio"), PLANNED)
@pytest.mark.parametrize("name", SPECS)
def test_float32_volume_is_reached(name, kind, ratio, shares, method):
    control = planned(name, kind, ratio)
    binding = bound(name, "float32", "gpu")
    result = binding.preserve(control, axes=shares, method=method)
    assert result.device == "gpu"
    assert result.method == method
    found = oracle.volume(result.vertices, meshes.bumpy_ball(3, 0.15)[1], SPECS[name].centre)
    assert abs(found / binding.reference_volume - 1) <= VOLUME
    assert result.target == binding.reference_volume
    assert result.error <= VOLUME
    still = np.array(shares) == 0
    np.testing.assert_array_equal(result.control[..., still], control[..., still])
    cpu = bound(name, "float32", "cpu").preserve(control, axes=shares, method=method)
    assert cpu.device == "cpu"
    atol = SHAPE * max(1.0, np.abs(cpu.control - control).max())
    np.testing.assert_allclose(result.vertices, cpu.vertices, rtol=0, atol=atol)
    np.testing.assert_allclose(result.control, cpu.control, rtol=0, atol=atol)


@pytest.mark.parametrize("method", ["sweep", "balanced"])
@pytest.mark.parametrize(("kind", "ratio"), [("squash", 0.15), ("twist", 0.34), ("inflate", 4.0)])
@pytest.mark.parametrize("name", SPECS)
def test_float64_vertices_keep_float64s_promise(name, kind, ratio, method):
    control = planned(name, kind, ratio)
    result = bound(name, "float64", "gpu").preserve(control, method=method)
    assert result.device == "gpu"
    assert result.vertices.dtype == np.float64
    assert result.error <= oracle.tolerance(
        result.vertices, meshes.bumpy_ball(3, 0.15)[1], SPECS[name].centre, result.target
    )


@pytest.mark.parametrize("amount", [0.0, 0.3, 1.0])
def test_options_reach_the_gpu(amount):
    control = planned("uniform-6", "squash", 0.36)
    weights = np.ones((6, 6, 6))
    weights[:, :, :2] = np.inf
    frame = [[1, 1, 0], [-1, 1, 0], [0, 0.2, 1]]
    options = {"axes": (1, 1, 0), "frame": frame, "weights": weights, "target": 0.2, "amount": amount}
    found = bound("uniform-6", "float32", "gpu").preserve(control, **options)
    expected = bound("uniform-6", "float32", "cpu").preserve(control, **options)
    assert (found.device, expected.device) == ("gpu", "cpu")
    assert found.error <= VOLUME
    assert found.target == pytest.approx(expected.target, rel=VOLUME)
    np.testing.assert_array_equal(found.control[:, :, :2], control[:, :, :2])
    np.testing.assert_allclose(found.control, expected.control, rtol=0, atol=SHAPE)


@pytest.mark.parametrize("name", SPECS)
def test_deforming_is_float32_accurate_and_rest_is_exact(name):
    binding, cpu = bound(name, "float32", "gpu"), bound(name, "float32", "cpu")
    vertices = meshes.bumpy_ball(3, 0.15)[0].astype(np.float32)
    assert binding.device == "gpu"
    np.testing.assert_array_equal(binding.deform(SPECS[name].rest), vertices)
    np.testing.assert_array_equal(binding.preserve(SPECS[name].rest).vertices, vertices)
    control = planned(name, "twist", 0.34)
    np.testing.assert_allclose(binding.deform(control), cpu.deform(control), rtol=0, atol=1e-6)


def test_a_flat_axis_is_left_to_the_cpu_without_a_warning(recwarn):
    flat = SPECS["bernstein-4"].rest * [1, 1, 0]
    result = bound("bernstein-4", "float32", "gpu").preserve(flat)
    assert result.device == "cpu"
    assert result.error <= VOLUME
    assert not recwarn.list
