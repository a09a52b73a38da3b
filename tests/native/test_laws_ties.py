# SPDX-License-Identifier: GPL-3.0-or-later
"""Neighbouring blocks tied at a face: joined to C0, C1, C2 with the least change of the follower."""

from dataclasses import replace

import isochor
import lattices
import numpy as np
import pytest
from isochor import LatticeError
from oracle import Array, Spec
from refusals import refused

FACES = ("s0", "s1", "t0", "t1", "u0", "u1")
SKEW = np.array([[1.3, 0.2, -0.1], [-0.4, 1.1, 0.3], [0.25, -0.2, 1.2]])
KINDS = {
    "bernstein": Spec((4, 5, 3)),
    "uniform": Spec((7, 6, 6), "bspline", 3, "uniform"),
    "clamped": Spec((6, 5, 5), "bspline", (3, 2, 2), "clamped"),
}


def neighbours(kind: str, axis: int = 0, width: float = 0.6) -> tuple[Spec, Spec]:
    """A block, and one beside it along an axis, with the same functions in the face and another number across it."""
    first = replace(KINDS[kind], edges=tuple(map(tuple, SKEW.tolist())))
    origin, edges = SKEW[axis], SKEW.copy()
    edges[axis] *= width
    shape = list(first.shape)
    shape[axis] += 1
    second = replace(first, shape=tuple(shape), origin=tuple(origin.tolist()), edges=tuple(map(tuple, edges.tolist())))
    return first, second


def posed(spec: Spec, seed: int) -> Array:
    return lattices.noisy(spec, 0.2, seed)


def on_face(axis: int, side: int) -> Array:
    unit = np.random.default_rng(3).random((60, 3))
    unit[:, axis] = side
    return unit


def world_slopes(spec: Spec, at: Array, control: Array) -> Array:
    """(V, 3) derivative of the map along the first lattice's edge direction, in the world."""
    jacobian = spec.build().derivative(at, control)  # rows d/ds, d/dt, d/du
    return np.linalg.solve(np.asarray(spec.edges)[None], jacobian)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("continuity", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("leader", ["a", "b"])
def test_the_joint_is_smooth(kind, continuity, axis, leader):
    """The same places on the face from both sides, and for C1 the same derivative of the map in every direction."""
    a, b = neighbours(kind, axis)
    tie = isochor.Tie(a.build(), FACES[2 * axis + 1], b.build(), FACES[2 * axis], continuity=continuity)
    poses = {"a": posed(a, 1), "b": posed(b, 2)}
    follower = "b" if leader == "a" else "a"
    given = {name: pose.copy() for name, pose in poses.items()}
    poses[follower] = tie.apply(poses[leader], poses[follower], leader=leader)
    np.testing.assert_array_equal(given[leader], poses[leader])
    at_a, at_b = on_face(axis, 1), on_face(axis, 0)
    here, there = a.build().evaluate(at_a, poses["a"]), b.build().evaluate(at_b, poses["b"])
    np.testing.assert_allclose(here, there, rtol=0, atol=1e-12)
    if continuity:
        here, there = world_slopes(a, at_a, poses["a"]), world_slopes(b, at_b, poses["b"])
        np.testing.assert_allclose(here, there, rtol=0, atol=1e-10)


@pytest.mark.parametrize("continuity", [0, 1, 2])
@pytest.mark.parametrize("kind", ["bernstein", "uniform"])
def test_no_shorter_change_would_do(kind, continuity):
    """The least displacement under the joint's conditions, from a dense system of one-sided derivatives."""
    a, b = neighbours(kind)
    leader, follower = posed(a, 1), posed(b, 2)
    moved = isochor.Tie(a.build(), "s1", b.build(), "s0", continuity=continuity).apply(leader, follower)
    places = np.random.default_rng(5).random((60, 2))
    left, right = rows(a, 1.0, places, continuity, 1.0), rows(b, 0.0, places, continuity, 0.6)
    wanted = left @ (leader - a.rest).reshape(-1, 3) - right @ (follower - b.rest).reshape(-1, 3)
    shortest = np.linalg.lstsq(right, wanted, rcond=1e-10)[0].reshape(follower.shape)
    np.testing.assert_allclose(moved - follower, shortest, rtol=0, atol=1e-7)


def rows(spec: Spec, side: float, places: Array, orders: int, width: float) -> Array:
    """Rows that give displacement and its derivatives across the face, by exact fits on the first piece."""
    inner = 0.15 if side == 0.0 else 0.85
    degree = spec.axis_degree(0)
    depth = np.linspace(side, inner, degree + 1)
    values = spec.axis_weights(0, depth)
    powers = np.linalg.solve(np.vander((depth - side) * width, increasing=True), values)
    across = np.einsum("vj,vk->vjk", spec.axis_weights(1, places[:, 0]), spec.axis_weights(2, places[:, 1]))
    return np.concatenate(
        [np.einsum("i,vjk->vijk", powers[order], across).reshape(len(places), -1) for order in range(orders + 1)]
    )


@pytest.mark.parametrize("continuity", [0, 1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_joined_already_stays(kind, continuity):
    """Applied twice is applied once; an affine motion of both blocks is joined as it is."""
    if kind == "clamped" and continuity == 2:
        return
    a, b = neighbours(kind, 0)
    tie = isochor.Tie(a.build(), "s1", b.build(), "s0", continuity=continuity)
    leader = posed(a, 1)
    once = tie.apply(leader, posed(b, 2))
    np.testing.assert_allclose(tie.apply(leader, once), once, rtol=0, atol=1e-11)
    linear, offset = lattices.affine()
    moved = [spec.rest @ linear.T + offset for spec in (a, b)]
    np.testing.assert_allclose(tie.apply(*moved), moved[1], rtol=0, atol=1e-11)


def test_only_the_layers_at_the_face_move():
    a, b = neighbours("bernstein")
    follower = posed(b, 2)
    for continuity in (0, 1, 2):
        moved = isochor.Tie(a.build(), "s1", b.build(), "s0", continuity=continuity).apply(posed(a, 1), follower)
        np.testing.assert_array_equal(moved[continuity + 1 :], follower[continuity + 1 :])
        assert np.abs(moved[: continuity + 1] - follower[: continuity + 1]).min(axis=(1, 2, 3)).max() > 0


def test_a_mesh_across_the_joint_is_smooth():
    """Ferrier: points that meet have the same position and derivative. Measured on a deformed line."""
    a, b = neighbours("bernstein")
    leader = posed(a, 1)
    follower = isochor.Tie(a.build(), "s1", b.build(), "s0", continuity=1).apply(leader, posed(b, 2))
    depth = np.array([-2e-4, -1e-4, 0.0, 1e-4, 2e-4])
    line = np.array([1, 0.4, 0.7]) @ SKEW + depth[:, None] * SKEW[0]
    left = a.build().bind(line[:3], outside="extend").deform(leader)
    right = b.build().bind(line[2:], outside="extend").deform(follower)
    np.testing.assert_allclose(left[2], right[0], rtol=0, atol=1e-13)
    one_sided = (3 * left[2] - 4 * left[1] + left[0]) / 2e-4, (-3 * right[0] + 4 * right[1] - right[2]) / 2e-4
    np.testing.assert_allclose(*one_sided, rtol=0, atol=1e-5)


def test_faces_that_do_not_coincide_are_refused_with_how_far():
    a, b = neighbours("bernstein")
    apart = b.moved(offset=(0.25, 0, 0))
    with refused(LatticeError, "face", "0.25"):
        isochor.Tie(a.build(), "s1", apart.build(), "s0")
    with refused(LatticeError, "face"):
        isochor.Tie(a.build(), "s0", b.build(), "s0")


@pytest.mark.parametrize("face", ["x0", "s2", "", None, 3], ids=repr)
def test_faces_have_names(face):
    a, b = neighbours("bernstein")
    with refused(LatticeError, "face", "s0", "u1"):
        isochor.Tie(a.build(), face, b.build(), "s0")


@pytest.mark.parametrize("continuity", [-1, 9, 1.5, "smooth"], ids=repr)
def test_continuity_is_a_small_number(continuity):
    a, b = neighbours("bernstein")
    with refused(LatticeError, "continuity"):
        isochor.Tie(a.build(), "s1", b.build(), "s0", continuity=continuity)
