# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes bound in a shaped lattice, on the GPU: identity, motion and volume as on the CPU."""

import lattices
import meshes
import numpy as np
import oracle
import pytest
from promised import SPECS

each_spec = pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)


def bound(spec, device: str):
    vertices, triangles = meshes.bumpy_ball(3, 0.15)
    rest = lattices.noisy(spec, 0.4 / max(spec.shape))
    return spec.build().bind(vertices.astype(np.float32), triangles, rest=rest, device=device), rest


@each_spec
def test_the_bound_shape_is_the_identity_to_the_bit(spec):
    binding, rest = bound(spec, "gpu")
    np.testing.assert_array_equal(binding.deform(rest), meshes.bumpy_ball(3, 0.15)[0].astype(np.float32))
    assert binding.device == "gpu"


@each_spec
def test_the_volume_is_kept_as_on_the_cpu(spec):
    (on_gpu, rest), (on_cpu, _) = bound(spec, "gpu"), bound(spec, "cpu")
    control = (rest - spec.centre) * (1.1, 1.0, 0.4) + spec.centre
    np.testing.assert_allclose(on_gpu.deform(control), on_cpu.deform(control), rtol=0, atol=2e-6)
    result = on_gpu.preserve(control)
    assert result.device == "gpu"
    found = oracle.volume(result.vertices, meshes.bumpy_ball(3, 0.15)[1], spec.centre)
    assert abs(found / on_gpu.reference_volume - 1) <= 1e-6
    np.testing.assert_allclose(result.vertices, on_cpu.preserve(control).vertices, rtol=0, atol=2e-5)
