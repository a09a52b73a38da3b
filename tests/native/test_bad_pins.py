# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins that cannot be: repeated, contradicting, dependent or immovable ones are named, and no lattice goes wild."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import oracle
import pytest
from isochor import PinError, VolumeError
from oracle import Spec
from refusals import refused

MESH = meshes.bumpy_ball(2, 0.2)
each_method = pytest.mark.parametrize("method", cases.METHODS)
BINDING = Spec().build().bind(*MESH)
REST = Spec().rest
each_target = pytest.mark.parametrize("apart", [0.0, 0.1], ids=["same-target", "contradicting"])


@each_target
@each_method
def test_a_repeated_pin_is_named(apart, method):
    places = MESH[0][[9, 42, 9]] + [[0, 0, 0], [0, 0, 0], [apart, 0, 0]]
    with refused(PinError, 0, 2, 9):
        BINDING.preserve(REST, method=method, pins=([9, 42, 9], places))


@each_target
def test_a_face_point_on_a_pinned_vertex_is_named(apart):
    face = int(np.flatnonzero((MESH[1] == 9).any(axis=1))[0])
    corner = (MESH[1][face] == 9).astype(float)
    twice = np.stack([corner, corner])
    with refused(PinError, "pin", 0, 1):
        BINDING.preserve(REST, pins=isochor.Pins([face, face], [MESH[0][9], MESH[0][9] + apart], twice))


@each_target
def test_two_vertices_at_one_place_cannot_be_pinned_apart(apart):
    double = meshes.joined(MESH, MESH)
    other = 9 + len(MESH[0])
    binding = Spec().build().bind(*double)
    with refused(PinError, "pin", (0, 9), (1, other)):
        binding.preserve(REST, pins=([9, other], [MESH[0][9], MESH[0][9] + apart]))


def test_more_pins_than_the_lattice_has_points():
    """Nine pins on a lattice of eight points: the last depends on the others."""
    chosen = np.arange(9) * 13
    binding = Spec((2, 2, 2)).build().bind(*MESH)
    with refused(PinError, "pin"):
        binding.preserve(Spec((2, 2, 2)).rest, pins=(chosen, MESH[0][chosen] * 1.1))


def test_pins_on_one_line_that_the_lattice_keeps_straight():
    """Trilinear lattices keep a line along an axis straight: three points of it are dependent, two are not."""
    vertices, triangles = meshes.box(4)
    line = [int(np.argmin(np.abs(vertices - [x, 0.1, 0.1]).sum(axis=1))) for x in (0.1, 0.5, 0.9)]
    spec = Spec((2, 2, 2))
    binding = spec.build().bind(vertices, triangles)
    places = vertices[line] + [[0, 0, 0], [0, 0.1, 0], [0, 0, 0]]
    with refused(PinError, "pin", (2, line[2])):
        binding.preserve(spec.rest, pins=(line, places))
    binding.preserve(spec.rest, pins=(line[:2], places[:2]))


IMMOVABLE = {
    "masked": ({"influence": np.where(np.arange(len(MESH[0])) == 42, 0.0, 1.0)}, {}),
    "outside": ({"outside": "keep"}, {}),
    "frozen": ({}, {"weights": np.full((4, 4, 4), np.inf)}),
}


@pytest.mark.parametrize("why", IMMOVABLE)
def test_a_pin_that_nothing_can_move_is_named(why):
    bound, options = IMMOVABLE[why]
    offset = np.array([0.0, 0.0, 0.4]) if why == "outside" else np.zeros(3)
    vertices = MESH[0] + offset
    top = 42 if why != "outside" else int(np.argmax(vertices[:, 2]))
    low = int(np.argmin(vertices[:, 2]))
    lattice = Spec((6, 6, 6), "bspline", 1, "clamped").build() if why == "outside" else Spec().build()
    binding = lattice.bind(vertices, MESH[1], **bound)
    with refused(PinError, "pin", (1, top) if why != "frozen" else (0, low)):
        binding.preserve(lattice.rest, pins=([low, top], vertices[[low, top]] + 0.05), **options)


def test_pins_that_leave_the_volume_no_freedom():
    """All corners of a tetrahedron pinned: the volume is that of the pinned corners, and the error says it."""
    vertices, triangles = meshes.tetrahedron()
    places = vertices * [1, 1, 0.5]
    with refused(VolumeError, "volume") as caught:
        Spec().build().bind(vertices, triangles).preserve(REST, pins=([0, 1, 2, 3], places))
    assert says_number(str(caught.value), oracle.volume(places, triangles))


def test_a_volume_already_right_needs_no_freedom():
    vertices, triangles = meshes.tetrahedron()
    places = vertices @ lattices.rotation().T + 0.1
    result = Spec().build().bind(vertices, triangles).preserve(REST, pins=([0, 1, 2, 3], places))
    np.testing.assert_allclose(result.vertices, places, rtol=0, atol=1e-12)


@pytest.mark.parametrize("apart", 10.0 ** -np.arange(3, 15, 2))
@each_method
def test_nearly_dependent_pins_are_exact_or_refused_but_never_wild(apart, method):
    """Two points of a face, `apart` of it from each other, pulled apart by as much: a slope of about 1 is wanted."""
    spec = Spec()
    control = spec.centre + (lattices.noisy(spec, 0.1) - spec.centre) * [1.1, 0.9, 0.5]
    binding = spec.build().bind(*MESH)
    barycentric = np.array([[0.3, 0.3, 0.4], [0.3 + apart, 0.3, 0.4 - apart]])
    corners = binding.deform(control)[MESH[1][[11, 11]]]
    places = np.einsum("pk,pkx->px", barycentric, corners) + [[0.05, 0, 0], [0.05, 0.1 * apart, 0]]
    try:
        result = binding.preserve(control, method=method, pins=isochor.Pins([11, 11], places, barycentric))
    except PinError:
        assert apart < 1e-6
        return
    landed = np.einsum("pk,pkx->px", barycentric, result.vertices[MESH[1][[11, 11]]])
    np.testing.assert_allclose(landed, places, rtol=0, atol=1e-12)
    assert np.abs(result.control - control).max() < 5


@pytest.mark.parametrize(
    ("pins", "said"),
    [
        (lambda: isochor.Pins([10**6], [[0.0, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0], [[np.nan, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0, 1], [[0.0, 0, 0]]), "pin"),
        (lambda: isochor.Pins([0], [[0.0, 0, 0]], [[0.5, np.nan, 0.5]]), ("barycentric", "pin")),
        (lambda: isochor.Pins([0], [[0.0, 0, 0]], [[0.5, 0.5]]), ("barycentric", "pin")),
        (lambda: isochor.Pins([10**6], [[0.0, 0, 0]], [[0.2, 0.3, 0.5]]), "pin"),
        (lambda: isochor.Pins([-1], [[0.0, 0, 0]]), "pin"),
    ],
)
def test_pins_that_are_none(pins, said):
    with refused(isochor.Error, said):
        BINDING.preserve(REST, pins=pins())


def says_number(message: str, value: float, rel: float = 1e-3) -> bool:
    """Whether the message names the value, to a thousandth."""
    return any(abs(found - value) <= rel * abs(value) for found in cases.numbers(message))
