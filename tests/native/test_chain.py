# SPDX-License-Identifier: GPL-3.0-or-later
"""Several lattices one after the other through the Python module."""

import threading

import isochor
import meshes
import numpy as np
import oracle
import pytest
from isochor import LatticeError, MeshError, VolumeError
from refusals import refused

MESH = meshes.bumpy_ball(3)
AROUND = isochor.Lattice(shape=(5, 4, 5), basis="bspline")
LOCAL = isochor.Lattice(shape=(4, 4, 4), origin=(0.4, 0.3, 0.3), edges=np.diag([0.5, 0.6, 0.6]))
LAST = isochor.Lattice(shape=(4, 4, 4), origin=(-0.2, -0.2, -0.2), edges=np.diag([1.4, 1.4, 1.4]))
LINKS = [(AROUND, {"outside": "extend"}), (LOCAL, {}), (LAST, {"outside": "extend"})]


def shaken(seed: int):
    random = np.random.default_rng(seed)
    shake = lambda rest: (rest - 0.5) * [1.1, 0.9, 0.6] + 0.5 + 0.03 * random.standard_normal(rest.shape)  # noqa: E731
    return [shake(lattice.rest) for lattice, _ in LINKS]


def own(vertices) -> float:
    return float(oracle.volume(np.asarray(vertices, float), MESH[1]))


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("device", ["cpu", "gpu"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_it_deforms_in_order_and_keeps_the_volume_of_what_enters(dtype, device):
    vertices = MESH[0].astype(dtype)
    controls = shaken(1)
    expected = vertices
    for (lattice, options), control in zip(LINKS, controls, strict=True):
        expected = lattice.bind(expected, device="cpu", **options).deform(control)
    chain = isochor.Chain(LINKS, vertices, MESH[1], device)
    assert len(chain) == 3
    tolerance = 1e-12 if dtype == np.float64 else 1e-6
    found = chain.deform(controls)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, expected, atol=tolerance)
    assert chain.volume(controls) == pytest.approx(own(expected), rel=tolerance)
    assert chain.reference_volume == pytest.approx(own(vertices), rel=1e-12)
    for method in ("sweep", "balanced", "gradient", "nearest"):
        result = chain.preserve(controls, method=method)
        assert own(result.vertices) == pytest.approx(own(vertices), rel=tolerance)
        assert result.error < tolerance
        np.testing.assert_allclose(chain.deform([*controls[:2], result.control]), result.vertices, atol=10 * tolerance)


def test_options_of_preserve_are_those_of_the_last():
    chain = isochor.Chain(LINKS, *MESH)
    controls = shaken(2)
    target = 1.1 * chain.reference_volume
    assert own(chain.preserve(controls, target=target).vertices) == pytest.approx(target, rel=1e-12)
    half = chain.preserve(controls, amount=0.5)
    middle = (chain.reference_volume + chain.volume(controls)) / 2
    assert own(half.vertices) == pytest.approx(middle, rel=1e-12)
    held = chain.preserve(controls, pins=([7], [[0.5, 0.5, 0.9]]), axes=(1, 1, 0))
    np.testing.assert_allclose(held.vertices[7], [0.5, 0.5, 0.9], atol=1e-12)
    with refused(VolumeError, "axes"):
        chain.preserve(controls, axes=(0, 0, 0))
    with pytest.raises(TypeError):
        chain.preserve(controls, nonsense=1)
    open_chain = isochor.Chain(LINKS, MESH[0], MESH[1][1:])
    open_chain.preserve(controls, pins=([7], [[0.5, 0.5, 0.9]]), amount=0)
    with refused(MeshError, "open"):
        open_chain.preserve(controls)


def test_frames_do_not_depend_on_those_before():
    chain = isochor.Chain(LINKS, *MESH)
    frames = {seed: shaken(seed) for seed in (1, 2, 3)}
    expected = {seed: isochor.Chain(LINKS, *MESH).preserve(controls).vertices for seed, controls in frames.items()}
    for seed in (1, 2, 1, 3, 2):
        np.testing.assert_array_equal(chain.preserve(frames[seed]).vertices, expected[seed])
    found = {}
    work = lambda seed: found.setdefault(seed, chain.preserve(frames[seed]).vertices)  # noqa: E731
    threads = [threading.Thread(target=work, args=(seed,)) for seed in frames]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    for seed, vertices in found.items():
        np.testing.assert_array_equal(vertices, expected[seed])
    chain.update(MESH[0] * 0.9)
    fresh = isochor.Chain(LINKS, MESH[0] * 0.9, MESH[1]).preserve(frames[1])
    np.testing.assert_array_equal(chain.preserve(frames[1]).vertices, fresh.vertices)


def test_islands_rest_and_lattices_alone_are_options_too():
    both = meshes.joined(meshes.icosphere(2, 0.2, (0.3, 0.4, 0.5)), meshes.icosphere(2, 0.2, (0.7, 0.6, 0.5)))
    cubic = isochor.Lattice(shape=(6, 6, 6), basis="bspline")
    posed = AROUND.rest * [1.0, 1.0, 0.9]
    chain = isochor.Chain([(AROUND, {"rest": posed}), (cubic, {"bodies": "islands", "influence": None})], *both)
    squashed = (cubic.rest - 0.5) * [1.0, 1.0, 0.7] + 0.5
    result = chain.preserve([posed, squashed])
    np.testing.assert_allclose(result.volumes / result.targets, 1, rtol=1e-12)
    assert len(result.volumes) == 2
    alone = isochor.Chain([cubic], *both)
    np.testing.assert_array_equal(alone.deform([squashed]), cubic.bind(*both, device="cpu").deform(squashed))


def test_wrong_chains_are_refused():
    with refused(LatticeError, "lattices"):
        isochor.Chain([], *MESH)
    with refused(LatticeError, "lattices"):
        isochor.Chain(3, *MESH)
    with refused(LatticeError, "options", "nonsense"):
        isochor.Chain([(AROUND, {"nonsense": 1})], *MESH)
    chain = isochor.Chain(LINKS, *MESH)
    with refused(LatticeError, "controls", 2, 3):
        chain.deform(shaken(1)[:2])
    with refused(LatticeError, "controls"):
        chain.deform(shaken(1)[::-1])
    with refused(MeshError, "vertices"):
        chain.update(MESH[0][1:])
