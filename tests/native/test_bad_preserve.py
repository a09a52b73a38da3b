# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of `preserve` that have no meaning, and targets that cannot be reached, are refused and named."""

import isochor
import meshes
import numpy as np
import pytest
from isochor import VolumeError
from refusals import refused

NAN, INF = float("nan"), float("inf")
LATTICE = isochor.Lattice(shape=(4, 4, 4))
SQUASHED = LATTICE.rest * [1, 1, 0.4]
BINDING = LATTICE.bind(*meshes.icosphere(1))
CUBE = (4, 4, 4)


@pytest.mark.parametrize(
    "axes",
    [
        (0, 0, 0),
        (-1, -1, -1),
        (1, -1, 1),
        (1, NAN, 1),
        (1, INF, 1),
        (1, 1),
        (1, 1, 1, 1),
        1,
        (),
        "xyz",
        ("x", "y", "z"),
        (1, None, 1),
        np.eye(3),
        (1j, 1, 1),
    ],
    ids=repr,
)
def test_axes(axes):
    with refused(isochor.Error, ("axes", "axis")):
        BINDING.preserve(SQUASHED, axes=axes)


@pytest.mark.parametrize(
    "frame",
    [
        np.zeros((3, 3)),
        [[1, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[1, 2, 3], [4, 5, 6], [7, 8, 9]],
        [[NAN, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[1, 0, 0], [0, INF, 0], [0, 0, 1]],
        np.eye(2),
        np.eye(4),
        (1, 1, 1),
        "world",
        7,
        np.eye(3) * 1j,
    ],
    ids=repr,
)
def test_frame(frame):
    with refused(isochor.Error, "frame"):
        BINDING.preserve(SQUASHED, frame=frame)


@pytest.mark.parametrize("method", ["newton", "", None, 1, "SWEEP ", b"sweep"], ids=repr)
def test_unknown_method_lists_the_choices(method):
    with refused(isochor.Error, "method", "sweep", "balanced"):
        BINDING.preserve(SQUASHED, method=method)


def one_off(value):
    weights = np.ones(CUBE)
    weights[1, 2, 3] = value
    weights[3, 3, 3] = value
    return weights


@pytest.mark.parametrize("value", [0.0, -1.0, NAN, -INF], ids=repr)
def test_weights_that_are_not_positive(value):
    with refused(isochor.Error, "weight", (27, "[1, 2, 3]", "(1, 2, 3)")):
        BINDING.preserve(SQUASHED, weights=one_off(value))


@pytest.mark.parametrize(
    "weights",
    [np.ones((4, 4)), np.ones(64), np.ones((4, 4, 5)), np.ones((4, 4, 4, 3)), 2.0, "stiff", np.ones(CUBE, complex)],
    ids=lambda weights: str(getattr(weights, "shape", weights)),
)
def test_weights_of_the_wrong_kind(weights):
    with refused(isochor.Error, "weight"):
        BINDING.preserve(SQUASHED, weights=weights)


def test_all_weights_infinite():
    with refused(VolumeError, "weight"):
        BINDING.preserve(SQUASHED, weights=np.full(CUBE, INF))


@pytest.mark.parametrize("target", [NAN, INF, -INF, "more", (1, 2), 1j], ids=repr)
def test_target(target):
    with refused(isochor.Error, "target"):
        BINDING.preserve(SQUASHED, target=target)


@pytest.mark.parametrize("amount", [NAN, INF, "half", None, (0.5,), 1j], ids=repr)
def test_amount(amount):
    with refused(isochor.Error, "amount"):
        BINDING.preserve(SQUASHED, amount=amount)


@pytest.mark.parametrize(
    "pins",
    [
        ([10**6], [[0.0, 0.0, 0.0]]),
        ([-1], [[0.0, 0.0, 0.0]]),
        ([0], [[NAN, 0.0, 0.0]]),
        ([0, 1], [[0.0, 0.0, 0.0]]),
        ([0, 0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        "here",
        7,
    ],
    ids=repr,
)
def test_pins(pins):
    with refused(isochor.Error, "pin"):
        BINDING.preserve(SQUASHED, pins=pins)


@pytest.mark.parametrize("huge", [1e200, 1e308])
def test_numbers_whose_volume_overflows(huge):
    """Finite control points, but a volume beyond float64: an error, never a NaN in the result."""
    with refused(isochor.Error):
        BINDING.preserve(SQUASHED * huge)


def test_a_volume_of_zero_to_keep():
    with refused(VolumeError, "volume"):
        LATTICE.bind(*meshes.flat()).preserve(SQUASHED)


def test_the_binding_works_on_after_every_refusal():
    before = BINDING.preserve(SQUASHED).control
    for bad in ({"axes": (0, 0, 0)}, {"weights": np.full(CUBE, INF)}, {"target": NAN}, {"frame": np.zeros((3, 3))}):
        with refused(isochor.Error):
            BINDING.preserve(SQUASHED, **bad)
    np.testing.assert_array_equal(BINDING.preserve(SQUASHED).control, before)
