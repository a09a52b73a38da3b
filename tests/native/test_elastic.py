# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.Elastic: laws of motion through Python, and what it refuses."""

import isochor
import meshes
import numpy as np
import pytest
from isochor import Elastic, ElasticError, Lattice, LatticeError, MeshError
from refusals import refused
from test_threads import digest, longest_silence

NAN, INF = float("nan"), float("inf")
FRAME = 1.0 / 24.0
UNIT, TRIANGLES = meshes.icosphere(3)
VERTICES = (UNIT - 0.5) / np.abs(UNIT - 0.5).max()
LATTICE = Lattice(shape=(4, 4, 4), origin=(-1.1, -1.1, -1.1), edges=np.eye(3) * 2.2)
FLOOR = ((0, 0, -2), (0, 0, 1))


def test_free_fall_throw_and_time():
    velocity = np.broadcast_to((1.0, 2.0, 3.0), LATTICE.rest.shape)
    body = Elastic(LATTICE, VERTICES, TRIANGLES, velocity=velocity, gravity=(0, 0, -2))
    for _ in range(24):
        body.step(FRAME)
    assert body.time == pytest.approx(1.0)
    np.testing.assert_allclose(body.control, LATTICE.rest + (1.0, 2.0, 2.0), atol=1e-10)
    np.testing.assert_allclose(body.velocity, velocity - (0, 0, 2), atol=1e-9)
    np.testing.assert_allclose(body.momentum, body.mass * np.array([1.0, 2.0, 1.0]), rtol=1e-9)
    np.testing.assert_allclose(body.centre, (1.0, 2.0, 2.0), atol=1e-10)
    assert body.volume_ratio == pytest.approx(1.0, abs=1e-12)
    assert body.lowest is None


def test_spin_is_kept():
    spin = np.cross((0.0, 0.0, 3.0), LATTICE.rest)
    body = Elastic(LATTICE, VERTICES, TRIANGLES, velocity=spin, gravity=(0, 0, 0), damping=0)
    start = body.angular_momentum
    for _ in range(24):
        body.step(FRAME)
    np.testing.assert_allclose(body.angular_momentum, start, rtol=1e-9, atol=1e-9)
    assert body.volume_ratio == pytest.approx(1.0, abs=1e-5)


def test_the_ball_bounces_on_the_ground_and_comes_to_rest_there():
    body = Elastic(LATTICE, VERTICES, TRIANGLES, ground=FLOOR, damping=0.3)
    heights, lows = [], []
    for _ in range(24 * 8):
        body.step(FRAME)
        heights.append(body.centre[2])
        lows.append(body.lowest)
    start = sum(Elastic(LATTICE, VERTICES, TRIANGLES, ground=FLOOR).energy)
    assert sum(body.energy) < start
    assert min(lows) > -1e-3
    assert max(heights[20:]) > heights[-1] + 0.05, "it does not bounce"
    assert np.abs(body.velocity).max() < 0.05
    surface = LATTICE.evaluate(LATTICE.parameters(VERTICES), body.control)
    assert surface[:, 2].min() == pytest.approx(-2.0 + body.lowest, abs=1e-9)


@pytest.mark.parametrize("shape", [(4, 4, 1), (1, 4, 1), (2, 2, 2), (1, 1, 1)])
def test_flat_lattices(shape):
    lattice = Lattice(shape=shape, origin=(-1.1, -1.1, -1.1), edges=np.eye(3) * 2.2)
    body = Elastic(lattice, VERTICES, TRIANGLES, ground=FLOOR)
    for _ in range(48):
        body.step(FRAME)
    assert np.isfinite(body.control).all()
    assert -1e-3 < body.lowest < 0.5


def test_pinned_points_go_to_their_targets():
    pinned = LATTICE.rest[..., 2] > 1.0
    body = Elastic(LATTICE, VERTICES, TRIANGLES, pinned=pinned, frequency=4)
    targets = np.where(pinned[..., None], LATTICE.rest + (0.5, 0, 0), NAN)
    body.step(0.25, targets)
    np.testing.assert_array_equal(body.control[pinned], targets[pinned])
    assert 0.05 < body.centre[0] < 0.6


DIGEST = """
import hashlib
from test_elastic import *
lattice = Lattice(shape=(9, 9, 9), origin=(-1.1, -1.1, -1.1), edges=np.eye(3) * 2.2)
control = lattice.rest + np.random.default_rng(5).normal(size=lattice.rest.shape) * 0.02
body = Elastic(lattice, VERTICES, TRIANGLES, control=control, ground=((0, 0, -1.05), (0.1, 0, 1)))
for _ in range(6):
    body.step(FRAME)
print(hashlib.sha256(body.control.tobytes() + body.velocity.tobytes()).hexdigest())
"""


def test_the_same_bits_on_any_number_of_threads():
    assert len({digest(DIGEST, threads) for threads in (1, 1, 2, 5)}) == 1


def test_python_runs_on_meanwhile():
    body = Elastic(LATTICE, VERTICES, TRIANGLES, ground=FLOOR)
    shares = []
    for _ in range(8):
        took, silence = longest_silence(lambda: body.step(1.0))
        shares.append(silence / took)
    assert min(shares) < 0.5


@pytest.mark.parametrize("name", ["frequency", "damping", "friction", "volume", "seconds"])
@pytest.mark.parametrize("value", [NAN, INF, -1.0, "soft", None], ids=repr)
def test_numbers(name, value):
    with refused(ElasticError, name):
        if name == "seconds":
            Elastic(LATTICE).step(value)
        else:
            Elastic(LATTICE, ground=FLOOR, **{name: value})


@pytest.mark.parametrize("substeps", [0, -1, 2.5, 10**9, "many"], ids=repr)
def test_substeps(substeps):
    with refused(ElasticError, "substeps"):
        Elastic(LATTICE, substeps=substeps)


@pytest.mark.parametrize("ground", [(0, 0, 1), ((0, 0, 0), (0, 0, 0)), ((0, 0, NAN), (0, 0, 1)), "floor"], ids=repr)
def test_ground(ground):
    with refused(ElasticError, "ground"):
        Elastic(LATTICE, ground=ground)


@pytest.mark.parametrize("gravity", [(0, 0), (0, 0, INF), "down"], ids=repr)
def test_gravity(gravity):
    with refused(ElasticError, "gravity"):
        Elastic(LATTICE, gravity=gravity)


def test_a_time_that_is_too_long_for_the_stiffness_moves_nothing():
    body = Elastic(LATTICE, frequency=50)
    with refused(ElasticError, "seconds", "substeps"):
        body.step(1e6)
    np.testing.assert_array_equal(body.control, LATTICE.rest)


@pytest.mark.parametrize("name", ["control", "velocity"])
@pytest.mark.parametrize(
    "value", [np.zeros((4, 4, 4)), np.full((4, 4, 4, 3), NAN), "rest"], ids=["flat", "nan", "word"]
)
def test_starts(name, value):
    with refused(LatticeError, name):
        Elastic(LATTICE, **{name: value})


@pytest.mark.parametrize("pinned", [np.ones((4, 4), bool), np.ones((4, 4, 4)), "all"], ids=["shape", "floats", "word"])
def test_pinned(pinned):
    with refused(LatticeError, "pinned"):
        Elastic(LATTICE, pinned=pinned)


def test_targets():
    body = Elastic(LATTICE, pinned=np.ones((4, 4, 4), bool))
    for targets in (np.zeros((4, 4, 3, 3)), np.full((4, 4, 4, 3), INF)):
        with refused(LatticeError, "targets"):
            body.step(FRAME, targets)


def test_surfaces():
    with refused(MeshError, "triangles", 3):
        Elastic(LATTICE, VERTICES, TRIANGLES[1:])
    with refused(MeshError, "triangles"):
        Elastic(LATTICE, VERTICES[:10], TRIANGLES)
    with refused(MeshError, "vertices"):
        Elastic(LATTICE, VERTICES * NAN, TRIANGLES)
    with refused(MeshError, "influence"):
        Elastic(LATTICE, VERTICES, TRIANGLES, influence=np.full(len(VERTICES), 2.0))


def test_not_a_lattice():
    with refused(LatticeError, "lattice"):
        Elastic("lattice")
    assert issubclass(isochor.ElasticError, isochor.Error)
