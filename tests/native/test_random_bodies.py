# SPDX-License-Identifier: GPL-3.0-or-later
"""Random sets of bodies with pins, weights and axes: every body exact, every pin exact, whatever the method."""

import cases
import closings
import lattices
import meshes
import numpy as np
import oracle
import pytest
from oracle import Embedded, Spec

SPECS = (
    Spec((4, 4, 4)),
    Spec((5, 6, 5), "bspline", 3, "uniform"),
    Spec((6, 5, 6), "bspline", 2, "clamped"),
    Spec((7, 7, 7), "bspline", 3, "uniform"),
)
CORNERS = np.array([(x, y, z) for x in (0.27, 0.73) for y in (0.27, 0.73) for z in (0.27, 0.73)])


def random_task(seed: int, dtype: type):
    """A binding of two to four bodies, the oracle's bodies, an animator's lattice, and the arguments of `preserve`."""
    random = np.random.default_rng(seed)
    spec = SPECS[random.integers(len(SPECS))]
    places = CORNERS[random.permutation(8)[: 2 + seed % 3]] + random.uniform(-0.02, 0.02, (2 + seed % 3, 3))
    balls = [meshes.icosphere(1, 10.0 ** random.uniform(-2, -0.7), place) for place in places]
    vertices, triangles = balls[0]
    for ball in balls[1:]:
        vertices, triangles = meshes.joined((vertices, triangles), ball)
    vertices = vertices.astype(dtype)
    labels: object = "islands"
    bodies = closings.islands(triangles)
    if seed % 4 == 3:  # the first ball in two halves, each closed by a fan over their common border
        half = (triangles.max(axis=1) < 42) & (vertices[triangles].mean(axis=1)[:, 2] > places[0, 2])
        labels = np.where(half, len(balls), triangles[:, 0] // 42)
        bodies = closings.regions(triangles, labels)
    elif seed % 4 == 1:  # a hole in the first
        triangles = triangles[1:]
        bodies = closings.islands(triangles)
    binding = spec.build().bind(vertices, triangles, device="cpu", bodies=labels, caps=True)
    linear = lattices.rotation(random.normal(size=3), random.uniform(0, 3)) * random.uniform(0.5, 1.6, 3)
    control = spec.centre + (lattices.noisy(spec, 0.05, seed) - spec.centre) @ linear.T
    options = {"axes": tuple(map(float, [(1, 1, 1), (1, 1, 0), (2, 1, 3)][random.integers(3)]))}
    if random.random() < 0.5:
        options["weights"] = np.exp(random.uniform(0, 4, spec.shape))
    return spec, binding, vertices, triangles, bodies, control, options, random


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("method", cases.METHODS)
def test_every_body_and_every_pin_is_exact(method, dtype):
    for seed in range(60):
        spec, binding, vertices, triangles, bodies, control, options, random = random_task(seed, dtype)
        embedded = Embedded.of(spec, vertices, triangles)
        chosen = random.choice(len(vertices), seed % 3, replace=False)
        moves = random.uniform(-0.03, 0.03, (len(chosen), 3))
        pins = (chosen, embedded.deform(control)[chosen] + moves)
        targets = closings.closed_volumes(vertices.astype(float), bodies) * random.uniform(0.8, 1.2, len(bodies))
        result = binding.preserve(control, method=method, target=targets, pins=pins, **options)
        found = closings.closed_volumes(result.vertices.astype(float), bodies)
        for k, body in enumerate(bodies):
            room = oracle.tolerance(result.vertices, body, spec.centre, targets[k])
            assert abs(found[k] - targets[k]) <= room * abs(targets[k]), f"case {seed}, body {k}, {result.method}"
        room = oracle.tolerance(result.vertices, triangles, spec.centre, targets.sum())
        size = np.ptp(result.vertices, axis=0).max()
        np.testing.assert_allclose(result.vertices[chosen], pins[1], rtol=0, atol=room * size, err_msg=f"case {seed}")
