# SPDX-License-Identifier: GPL-3.0-or-later
"""The input Joint: how smoothly what a lattice moves joins vertices beyond it, measured across its face."""

import bpy
import native_scenes
import numpy as np
import pytest
import scenes

STEPS = np.array([0.4, 0.2, 0.1, 0.05])
"""Distances of rings of vertices from the face, each half of the one before."""
SIDE = 12
ORDER = {"C0": 1, "C1": 2, "C2": 3}
"""With which power of the distance from the face a displacement vanishes that joins so."""


def tube() -> tuple[bpy.types.Object, dict[float, np.ndarray]]:
    """A closed tube along x, which crosses the face x = 1; vertices of the rings by their distance from it."""
    places = [-0.9, -0.5, 0.0, 0.3, *(1.0 - STEPS), 1.0, 1.2, 1.6]
    angles = 2 * np.pi * np.arange(SIDE) / SIDE
    ring = np.stack([0.6 * np.cos(angles), 0.5 * np.sin(angles)], axis=-1)
    points = [(x, y, z) for x in places for y, z in ring]
    faces = [
        (i * SIDE + j, i * SIDE + (j + 1) % SIDE, (i + 1) * SIDE + (j + 1) % SIDE, (i + 1) * SIDE + j)
        for i in range(len(places) - 1)
        for j in range(SIDE)
    ]
    triangles = [half for a, b, c, d in faces for half in ((a, c, b), (a, d, c))]
    last = (len(places) - 1) * SIDE
    triangles += [(0, j, j + 1) for j in range(1, SIDE - 1)]
    triangles += [(last, last + j + 1, last + j) for j in range(1, SIDE - 1)]
    rings = {round(1.0 - x, 3): np.arange(SIDE) + i * SIDE for i, x in enumerate(places)}
    return scenes.mesh_object("Tube", points, triangles), rings


def scene(basis: str, points: int = 8, **inputs):
    obj, rings = tube()
    lattice = scenes.lattice_object((points, 4, 4), name="Cage", size=2.0)
    if basis == "B-Spline":
        lattice.scale = (2.0 * (points - 1) / (points - 3), 6.0, 6.0)
    random = np.random.default_rng(4)
    for point in lattice.data.points:
        point.co_deform = [place + random.normal(0.0, 0.08) for place in point.co_deform]
    modifier = scenes.volume_lattice(obj, lattice, Basis=basis, Preserve=0.0, **inputs)
    return obj, rings, modifier


def moved(obj: bpy.types.Object, rings: dict[float, np.ndarray]) -> dict[float, float]:
    """How far each ring's vertices are moved, at most."""
    bpy.context.view_layer.update()
    way = np.linalg.norm(scenes.evaluated_positions(obj) - scenes.positions(obj.data), axis=1)
    return {distance: float(way[ring].max()) for distance, ring in rings.items()}


@pytest.mark.parametrize("preserve", [0.0, 1.0])
@pytest.mark.parametrize("joint", ORDER)
@pytest.mark.parametrize("basis", ["Bernstein", "B-Spline"])
def test_the_displacement_vanishes_with_the_order_of_the_joint(basis, joint, preserve):
    obj, rings, modifier = scene(basis, Joint=joint)
    scenes.set_input(modifier, "Preserve", preserve)
    found = moved(obj, rings)
    assert scenes.report(obj, modifier).problems == ()
    assert found[0.0] <= 1e-6
    assert found[-0.2] == found[-0.6] == 0.0
    # One-sided: halving the distance divides the displacement by 2 to the order, ever more closely.
    near = np.log2(found[0.1] / found[0.05])
    # A cubic B-spline meets what stays with C2 as soon as it meets it at all.
    assert near == pytest.approx(3 if basis == "B-Spline" else ORDER[joint], abs=0.35)
    assert found[1.0] > 0.02
    if preserve:
        assert abs(scenes.evaluated_volume(obj) / scenes.volume(obj.data) - 1) <= 1e-6


def test_free_tears_and_the_lattice_off_the_mesh_is_not_held():
    obj, rings, modifier = scene("Bernstein")
    assert moved(obj, rings)[0.0] > 0.01
    scenes.set_input(modifier, "Joint", "C2")
    assert moved(obj, rings)[1.0] > 0.01
    report = scenes.report(obj, modifier)
    rest = scenes.part("core.grid").build_lattice(report.grid).rest
    held = np.abs(np.asarray(report.control) - rest).max(axis=(1, 2, 3)) < 1e-6
    assert held.tolist() == [False] * 5 + [True] * 3


def test_with_extend_it_is_said_and_has_no_effect():
    obj, rings, modifier = scene("Bernstein", Joint="C1", Outside="Extend")
    extended = moved(obj, rings)
    assert any("Outside is Extend" in text for text in scenes.report(obj, modifier).problems)
    scenes.set_input(modifier, "Joint", "Free")
    assert moved(obj, rings) == extended
    assert scenes.report(obj, modifier).problems == ()


def test_keyed_it_rebinds_and_a_bake_holds_the_same(tmp_path):
    obj, rings, modifier = scene("Bernstein", points=4, Joint="C0")
    before = moved(obj, rings)
    scenes.set_input(modifier, "Joint", "C1")
    after = moved(obj, rings)
    assert after[0.1] < 0.5 * before[0.1]
    scenes.choose(obj)
    shown = scenes.evaluated_positions(obj)
    assert bpy.ops.isochor.bake(format="PC2", frame_start=1, frame_end=1, directory=str(tmp_path)) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert native_scenes.apart(scenes.evaluated_positions(obj), shown) <= 1e-6
