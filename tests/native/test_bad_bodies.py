# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that cannot be, and volumes that they cannot have together."""

import cases
import isochor
import lattices
import meshes
import numpy as np
import pytest
from isochor import MeshError, VolumeError
from oracle import Spec
from refusals import refused

SPEC = Spec((4, 4, 4))
each_method = pytest.mark.parametrize("method", cases.METHODS)


def test_islands_of_which_none_is_closed():
    with refused(MeshError, ("closed", "open", "hole")):
        SPEC.build().bind(*meshes.opened(meshes.icosphere(1)), bodies="islands").preserve(SPEC.rest)


@pytest.mark.parametrize(
    "labels",
    [np.zeros(3, int), np.full(80, -2), np.full(80, 0.5), np.full(80, -1), "pieces", np.r_[np.zeros(79, int), 2]],
    ids=["too-few", "below-minus-one", "no-integers", "no-body", "unknown-word", "a-number-left-out"],
)
def test_labels_that_are_none(labels):
    with refused(isochor.Error, ("bod", "label")):
        SPEC.build().bind(*meshes.icosphere(1), bodies=labels).preserve(SPEC.rest)


@pytest.mark.parametrize("target", [[1.0], [1.0, 2.0, 3.0], [1.0, np.nan], [[1.0, 2.0]]], ids=str)
def test_targets_that_do_not_fit_the_bodies(target):
    binding = SPEC.build().bind(*meshes.two_islands(), bodies="islands")
    with refused(isochor.Error, "target"):
        binding.preserve(SPEC.rest, target=target)


@each_method
def test_two_islands_in_one_place_cannot_have_two_volumes(method):
    """Their rows are the same: contradicting targets are refused, equal ones are kept."""
    ball = meshes.icosphere(1)
    binding = SPEC.build().bind(*meshes.joined(ball, ball), bodies="islands")
    control = SPEC.centre + (lattices.noisy(SPEC, 0.06) - SPEC.centre) * [1.05, 0.95, 0.55]
    with refused(VolumeError, ("bod", "island")):
        binding.preserve(control, method=method, target=binding.reference_volumes * [1, 1.1])


@each_method
def test_more_islands_than_the_axis_has_freedom(method):
    """Nine balls, eight control points, one axis: not all nine volumes can be had."""
    centres = [(x, y, z) for x in (0.25, 0.75) for y in (0.25, 0.75) for z in (0.25, 0.75)] + [(0.5, 0.5, 0.5)]
    mesh = meshes.icosphere(0, 0.1, centres[0])
    for centre in centres[1:]:
        mesh = meshes.joined(mesh, meshes.icosphere(0, 0.1, centre))
    spec = Spec((2, 2, 2))
    binding = spec.build().bind(*mesh, bodies="islands")
    wanted = binding.reference_volumes * np.linspace(0.8, 1.2, 9) ** 2
    with refused(VolumeError, "volume"):
        binding.preserve(spec.rest, method=method, axes=(0, 0, 1), target=wanted)
