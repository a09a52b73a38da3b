# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of the deformed space and colours of control points, without Blender's drawing."""

import isochor
import numpy as np
import pytest
import scenes

EDGES = np.array([(2.0, 0.3, 0.0), (0.0, 1.5, 0.2), (0.1, 0.0, 3.0)])
ORIGIN = np.array([0.4, -0.7, 1.1])
LATTICES = {
    "bernstein": {"shape": (4, 3, 5), "basis": "bernstein"},
    "uniform": {"shape": (6, 5, 4), "basis": "bspline", "degree": 3, "knots": "uniform"},
    "clamped": {"shape": (5, 4, 6), "basis": "bspline", "degree": 3, "knots": "clamped"},
}


def lattice_of(name: str) -> isochor.Lattice:
    return isochor.Lattice(**LATTICES[name], origin=ORIGIN, edges=EDGES)


def deformed(lattice: isochor.Lattice) -> np.ndarray:
    return lattice.rest + 0.3 * np.random.default_rng(4).normal(size=lattice.rest.shape)


def lines_of(pieces: np.ndarray, wanted) -> np.ndarray:
    """(lines, samples + 1, 3) points along each line, from its straight pieces, which must be joined."""
    count = len(scenes.part("core.isolines").isoparameters(wanted))
    pairs = pieces.reshape(count, -1, 2, 3)
    assert np.array_equal(pairs[:, :-1, 1], pairs[:, 1:, 0])
    return np.concatenate([pairs[:, :1, 0], pairs[:, :, 1]], axis=1)


@pytest.mark.parametrize("name", LATTICES)
@pytest.mark.parametrize("inside", [False, True])
def test_at_rest_lines_are_straight_evenly_spaced_and_along_the_edges(name, inside):
    isolines = scenes.part("core.isolines")
    wanted = isolines.Wanted(divisions=5, samples=12, inside=inside)
    lattice = lattice_of(name)
    lines = lines_of(isolines.isolines(lattice, lattice.rest, wanted), wanted)
    steps = np.diff(lines, axis=1)
    assert np.allclose(steps, steps[:, :1], atol=1e-12)
    for axis in range(3):
        some = lines[axis * len(lines) // 3 : (axis + 1) * len(lines) // 3]
        assert np.allclose(some[:, -1] - some[:, 0], EDGES[axis], atol=1e-12)
        starts = (some[:, 0] - ORIGIN) @ np.linalg.inv(EDGES)
        assert np.allclose(starts[:, axis], 0.0, atol=1e-12)
        others = np.delete(starts, axis, axis=1)
        assert np.allclose(others * 5, np.rint(others * 5), atol=1e-12)
        on_faces = np.isin(np.rint(others * 5), (0, 5)).any(axis=1)
        assert len(np.unique(np.rint(others * 5), axis=0)) == len(some) == (36 if inside else 20)
        assert on_faces.sum() == 20


@pytest.mark.parametrize("name", LATTICES)
def test_deformed_lines_pass_through_the_deformed_space(name):
    isolines = scenes.part("core.isolines")
    wanted = isolines.Wanted(divisions=3, samples=9, inside=True)
    lattice = lattice_of(name)
    control = deformed(lattice)
    lines = lines_of(isolines.isolines(lattice, control, wanted), wanted)
    at_rest = lines_of(isolines.isolines(lattice, lattice.rest, wanted), wanted)
    moved = lattice.evaluate(lattice.parameters(at_rest.reshape(-1, 3)), control)
    assert np.allclose(lines.reshape(-1, 3), moved, atol=1e-9)
    corners = np.array([(s, t, u) for s in (0.0, 1.0) for t in (0.0, 1.0) for u in (0.0, 1.0)])
    ends = np.concatenate([lines[:, 0], lines[:, -1]])
    for corner in lattice.evaluate(corners, control):
        assert np.linalg.norm(ends - corner, axis=1).min() < 1e-12


def test_more_samples_only_add_points_to_the_same_curves():
    isolines = scenes.part("core.isolines")
    lattice = lattice_of("bernstein")
    control = deformed(lattice)
    coarse, fine = isolines.Wanted(4, 8), isolines.Wanted(4, 32)
    some = lines_of(isolines.isolines(lattice, control, coarse), coarse)
    more = lines_of(isolines.isolines(lattice, control, fine), fine)
    assert np.allclose(more[:, ::4], some, atol=1e-12)


@pytest.mark.parametrize(("divisions", "samples"), [(1, 1), (7, 3), (8, 32), (5, 12)])
def test_lines_cross_at_points_that_both_have(divisions, samples):
    isolines = scenes.part("core.isolines")
    lines = isolines.isoparameters(isolines.Wanted(divisions, samples, inside=True))
    assert lines.shape[1] - 1 >= samples
    assert (lines.shape[1] - 1) % divisions == 0


@pytest.mark.parametrize("shape", [(4, 4, 4), (2, 3, 5), (1, 3, 2), (1, 1, 1)])
def test_neighbours_are_those_one_step_apart(shape):
    pairs = scenes.part("core.isolines").neighbours(shape)
    u, v, w = shape
    assert len(pairs) == (u - 1) * v * w + u * (v - 1) * w + u * v * (w - 1)
    places = np.stack(np.unravel_index(pairs, shape), axis=-1)
    assert (np.abs(np.diff(places, axis=1)).sum(axis=(1, 2)) == 1).all()
    assert len({tuple(sorted(pair)) for pair in pairs.tolist()}) == len(pairs)


def test_a_drawing_shows_where_the_correction_put_the_points():
    isolines = scenes.part("core.isolines")
    lattice = lattice_of("bernstein")
    asked, control = lattice.rest, deformed(lattice)
    found = isolines.drawing(lattice, asked, control, None)
    assert len(found.isolines) == 0
    assert np.allclose(found.points, control.reshape(-1, 3), atol=1e-6)
    assert np.allclose(found.paths[0::2], asked.reshape(-1, 3), atol=1e-6)
    assert np.allclose(found.paths[1::2], control.reshape(-1, 3), atol=1e-6)
    assert np.allclose(asked.reshape(-1, 3) + found.moved, control.reshape(-1, 3), atol=1e-12)
    assert {part.dtype for part in (found.lattice, found.points, found.paths)} == {np.dtype(np.float32)}


def test_displacements_are_measured_in_the_world():
    isolines = scenes.part("core.isolines")
    turned = np.array([(0.0, -2.0, 0.0, 5.0), (2.0, 0.0, 0.0, 6.0), (0.0, 0.0, 2.0, 7.0), (0.0, 0.0, 0.0, 1.0)])
    assert isolines.lengths(np.array([(3.0, 4.0, 0.0), (0.0, 0.0, 0.0)]), turned).tolist() == [10.0, 0.0]


def test_colours_run_from_one_end_of_the_ramp_to_the_other_and_never_back():
    isolines = scenes.part("core.isolines")
    fractions = np.linspace(0.0, 1.0, 201)
    found = isolines.colours(fractions)
    assert found.shape == (201, 4)
    assert ((found >= 0.0) & (found <= 1.0)).all()
    assert np.array_equal(found[[0, -1]], isolines.RAMP[[0, -1]])
    hue = np.degrees(
        np.arctan2(np.sqrt(3.0) * (found[:, 1] - found[:, 2]), 2 * found[:, 0] - found[:, 1] - found[:, 2])
    )
    hue = np.where(hue < -1.0, hue + 360.0, hue)
    assert (np.diff(hue) < 0.0).all()
    assert np.abs(np.diff(found, axis=0)).max() < 0.03
    assert np.array_equal(isolines.colours(np.array([-1.0, 7.0, np.nan])), isolines.RAMP[[0, -1, 0]])
