# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive tessellation through the Python module."""

import isochor
import meshes
import numpy as np
import oracle
import pytest
from isochor import LatticeError, MeshError
from refusals import refused

LATTICE = isochor.Lattice(shape=(5, 2, 2))
BOX = meshes.box(1, (0.0, 0.2, 0.2), (1.0, 0.8, 0.8))


def bent(angle: float = 1.5):
    """The lattice bent about an axis along t: its s edges become arcs."""
    x, y, z = np.moveaxis(LATTICE.rest, -1, 0)
    turn, radius = (x - 0.5) * angle, 1 / angle + z
    return np.stack([radius * np.sin(turn), y, radius * np.cos(turn)], axis=-1)


def worst(vertices, triangles, control) -> float:
    """Largest distance of edges' quarters from the straight edge, by the lattice's own map."""
    place = lambda points: LATTICE.evaluate(LATTICE.parameters(points), control)  # noqa: E731
    a, b = np.asarray(vertices, float)[triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)].transpose(1, 0, 2)
    start, along = place(a), place(b) - place(a)
    away = []
    for t in (0.25, 0.5, 0.75):
        way = place(a + t * (b - a)) - start
        on = np.einsum("ei,ei->e", way, along) / np.einsum("ei,ei->e", along, along)
        away.append(np.linalg.norm(way - on.clip(0, 1)[:, None] * along, axis=1).max())
    return max(away)


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize("tolerance", [0.02, 0.002])
def test_it_comes_as_close_as_wanted_without_cracks(dtype, tolerance):
    vertices, triangles = BOX[0].astype(dtype), BOX[1]
    found = isochor.tessellate(LATTICE, vertices, triangles, bent(), tolerance, levels=8)
    assert found.reached
    assert found.after <= tolerance < found.before
    assert found.levels > 0
    assert found.vertices.dtype == dtype
    assert found.triangles.dtype == np.int32
    assert worst(found.vertices, found.triangles, bent()) <= tolerance + 1e-6
    a, b, c = found.triangles.T
    edges = np.concatenate([np.stack(pair, 1) for pair in ((a, b), (b, c), (c, a))])
    np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    assert len(np.unique(edges, axis=0)) == len(edges)
    np.testing.assert_allclose(found.parents.apply(vertices), found.vertices, atol=1e-7)
    np.testing.assert_array_equal(found.vertices[: len(vertices)], vertices)
    assert oracle.volume(found.vertices.astype(float), found.triangles) == pytest.approx(0.36, rel=1e-6)
    assert np.bincount(found.parent_triangle, minlength=len(triangles)).min() >= 1
    deformed = LATTICE.bind(found.vertices, found.triangles, device="cpu").preserve(bent())
    assert deformed.error < (1e-12 if dtype == np.float64 else 1e-6)


def test_finer_tolerances_come_closer_to_the_volume_of_deformed_space():
    fine = isochor.tessellate(LATTICE, *BOX, bent(), 2e-5, levels=9)
    volume = lambda mesh: LATTICE.bind(mesh.vertices, mesh.triangles).volume(bent())  # noqa: E731
    errors = [
        abs(volume(isochor.tessellate(LATTICE, *BOX, bent(), tolerance, levels=9)) - volume(fine))
        for tolerance in (0.05, 0.01, 0.002)
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_bent_edges_are_those_that_the_lattice_bends():
    vertices, _ = BOX
    pairs = np.array([(i, j) for i in range(8) for j in range(i) if (vertices[i] != vertices[j]).sum() == 1])
    found = isochor.bent_edges(LATTICE, vertices, pairs, bent(), 0.01)
    assert found.dtype == np.bool_
    np.testing.assert_array_equal(found, vertices[pairs[:, 0], 0] != vertices[pairs[:, 1], 0])
    assert not isochor.bent_edges(LATTICE, vertices, pairs, bent(), 0.01, influence=np.zeros(8)).any()
    assert not isochor.bent_edges(LATTICE, vertices + 5, pairs, bent(), 1e-9).any()
    assert not isochor.bent_edges(LATTICE, vertices, pairs, bent(), 1e-9, rest=bent()).any()


def test_a_lack_of_levels_is_told():
    found = isochor.tessellate(LATTICE, *BOX, bent(), 1e-4, levels=2)
    assert not found.reached
    assert found.after > 1e-4
    assert found.levels == 2
    nothing = isochor.tessellate(LATTICE, *BOX, LATTICE.rest, 1e-9)
    assert nothing.reached
    assert nothing.levels == 0
    np.testing.assert_array_equal(nothing.triangles, BOX[1])


def test_wrong_arguments_are_refused():
    for tolerance, levels, said in ((0.0, 1, "tolerance"), (np.nan, 1, "tolerance"), (0.1, 13, "levels")):
        with refused(MeshError, said):
            isochor.tessellate(LATTICE, *BOX, bent(), tolerance, levels)
    with refused(MeshError, "triangles"):
        isochor.tessellate(LATTICE, BOX[0], BOX[1] + 8, bent(), 0.1)
    with refused(MeshError, "edges", 8):
        isochor.bent_edges(LATTICE, BOX[0], [[0, 8]], bent(), 0.1)
    with refused(MeshError, "influence"):
        isochor.tessellate(LATTICE, *BOX, bent(), 0.1, influence=[1.0])
    with refused(LatticeError, "control"):
        isochor.tessellate(LATTICE, *BOX, bent()[:4], 0.1)
