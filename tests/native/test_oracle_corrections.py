# SPDX-License-Identifier: GPL-3.0-or-later
"""The oracle of corrections checked by itself: the printed formulas satisfy their own constraints, and it agrees."""

import closings
import lattices
import meshes
import numpy as np
import oracle
import published
import pytest
from corrections import Correction, Solid, shortest
from oracle import Embedded, Spec
from scipy.optimize import minimize

SPEC = Spec((4, 4, 4))
MESH = meshes.bumpy_ball(2, 0.2)
CONTROL = SPEC.centre + (lattices.noisy(SPEC, 0.1) - SPEC.centre) * [1.1, 0.9, 0.5]


def embedded() -> Embedded:
    return Embedded.of(SPEC, *MESH)


def test_equation_5_is_the_volume_and_appendix_a_says_the_same_of_each_axis():
    x = embedded().deform(CONTROL)
    assert published.volume(x, MESH[1]) == pytest.approx(oracle.volume(x, MESH[1]), rel=1e-13)
    for turn in ([1, 2, 0], [2, 0, 1]):
        assert published.volume(x[:, turn], MESH[1]) == pytest.approx(oracle.volume(x, MESH[1]), rel=1e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_equations_10_to_12_predict_the_volume(axis):
    rows = embedded().rows
    alpha = published.coefficients(embedded().deform(CONTROL), MESH[1], rows, axis)
    step = np.random.default_rng(axis).normal(size=SPEC.shape)
    moved = CONTROL + step[..., None] * np.eye(3)[axis]
    predicted = embedded().volume(CONTROL) + alpha @ step.ravel()
    assert embedded().volume(moved) == pytest.approx(predicted, rel=1e-12)


def test_equation_21_as_printed_satisfies_its_constraints_and_is_the_shortest_that_does():
    random = np.random.default_rng(4)
    for _ in range(50):
        alpha, B_s = random.normal(size=64), random.random(64)
        T, S, a = random.normal(size=3)
        delta = published.step_21(alpha, B_s, T, S, a)
        assert alpha @ delta == pytest.approx(a, abs=1e-12)
        assert S + B_s @ delta == pytest.approx(T, abs=1e-12)
        free = random.normal(size=64)  # any other step that satisfies them differs by one within both null spaces
        free -= shortest(np.stack([alpha, B_s]), np.array([alpha @ free, B_s @ free]), np.ones(64))
        assert abs(delta @ free) <= 1e-12 * np.linalg.norm(free)
        np.testing.assert_allclose(
            delta, shortest(np.stack([B_s, alpha]), np.array([T - S, a]), np.ones(64)), rtol=0, atol=1e-13
        )


def test_the_problems_of_the_paper_as_printed():
    P, reference = CONTROL.reshape(-1, 3), oracle.volume(*MESH)
    rows = embedded().rows
    one = published.problem_1(P, rows, MESH[1], reference)
    assert published.volume(rows @ one, MESH[1]) == pytest.approx(reference, rel=1e-13)
    np.testing.assert_allclose(one, correction().sweep().reshape(-1, 3), rtol=0, atol=1e-12)
    T = rows[5] @ P + [0.1, -0.05, 0.2]
    two = published.problem_2(P, rows, MESH[1], reference, 5, T)
    assert published.volume(rows @ two, MESH[1]) == pytest.approx(reference, rel=1e-13)
    np.testing.assert_allclose(rows[5] @ two, T, rtol=0, atol=1e-13)
    ours = correction(pin_rows=rows[[5]], pin_moves=np.array([[0.1, -0.05, 0.2]])).sweep()
    np.testing.assert_allclose(two, ours.reshape(-1, 3), rtol=0, atol=1e-12)


def correction(bodies=None, mesh=MESH, **options) -> Correction:
    return Correction(Solid.of(Embedded.of(SPEC, *mesh), bodies), CONTROL, **options)


def pins(count=2, seed=0) -> dict:
    random = np.random.default_rng(seed)
    chosen = random.choice(len(MESH[0]), count, replace=False)
    return {"pin_rows": embedded().rows[chosen], "pin_moves": random.uniform(-0.1, 0.1, (count, 3))}


WEIGHTS = np.exp(np.random.default_rng(1).uniform(0, 3, SPEC.shape))
OPTIONS = {
    "plain": {},
    "pins": pins(),
    "weights": {"weights": WEIGHTS},
    "axes": {"axes": (1.0, 2.0, 0.0)},
    "all": {"weights": WEIGHTS, "axes": (1.0, 1.0, 0.0), **pins(), "frame": lattices.rotation()},
}
each_option = pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)


@each_option
@pytest.mark.parametrize("method", ["sweep", "balanced", "gradient", "nearest"])
def test_every_method_satisfies_the_constraints(method, options):
    asked = correction(**options)
    result = asked.nearest(asked.sweep()) if method == "nearest" else getattr(asked, method)()
    np.testing.assert_allclose(asked.solid.volumes(result), asked.targets(), rtol=1e-11)
    if "pin_rows" in options:
        moved = asked.pin_rows @ (result - CONTROL).reshape(-1, 3)
        np.testing.assert_allclose(moved, asked.pin_moves, rtol=0, atol=1e-12)


@each_option
def test_nearest_is_a_kkt_point_and_the_others_are_no_shorter(options):
    asked = correction(**options)
    result = asked.nearest(asked.sweep())
    assert asked.stationarity(result) <= 1e-9
    assert asked.stationarity(asked.sweep()) > 1e-3
    for other in (asked.sweep(), asked.balanced(), asked.gradient()):
        assert asked.distance(result) <= asked.distance(other)


def test_nearest_against_slsqp():
    spec = Spec((3, 2, 2))
    solid = Solid.of(Embedded.of(spec, *meshes.icosphere(1)))
    control = spec.centre + (lattices.noisy(spec, 0.1) - spec.centre) * [1, 1, 0.4]
    asked = Correction(solid, control)
    found = asked.nearest(asked.balanced())
    target = asked.targets()[0]
    constraint = {
        "type": "eq",
        "fun": lambda p: solid.volumes(p.reshape(control.shape))[0] - target,
        "jac": lambda p: solid.gradients(p.reshape(control.shape))[0].ravel(),
    }
    best = minimize(
        lambda p: np.sum((p - control.ravel()) ** 2),
        asked.balanced().ravel(),
        jac=lambda p: 2 * (p - control.ravel()),
        constraints=[constraint],
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 200},
    )
    assert asked.distance(found) == pytest.approx(np.sqrt(best.fun), rel=1e-5)


def test_bodies_each_reach_their_target():
    mesh = meshes.two_islands()
    asked = correction(closings.islands(mesh[1]), mesh)
    for result in (asked.sweep(), asked.balanced(), asked.nearest(asked.sweep())):
        np.testing.assert_allclose(asked.solid.volumes(result), asked.targets(), rtol=1e-11)
    np.testing.assert_allclose(asked.targets(), closings.closed_volumes(mesh[0], closings.islands(mesh[1])), rtol=1e-12)


def test_a_fan_about_the_mean_of_a_flat_hole_restores_the_volume():
    vertices, triangles = meshes.box(3)
    lid = np.all(vertices[triangles][:, :, 2] > 0.9 - 1e-9, axis=1)
    (volume,) = closings.closed_volumes(vertices, [triangles[~lid]])
    assert volume == pytest.approx(0.8**3, rel=1e-13)
    assert [len(loop) for loop in closings.loops(triangles[~lid])] == [12]


def test_regions_and_their_fans_add_up_to_the_whole():
    vertices, triangles = meshes.bumpy_ball(2)
    labels = (vertices[triangles].mean(axis=1)[:, 0] > 0.55).astype(int)
    parts = closings.closed_volumes(vertices, closings.regions(triangles, labels))
    assert parts.sum() == pytest.approx(oracle.volume(vertices, triangles), rel=1e-12)
    assert parts.min() > 0
