# SPDX-License-Identifier: GPL-3.0-or-later
"""The volumes that a frame is to have: one, or one for each body."""

import numpy as np
from numpy.typing import NDArray

import isochor

from . import problem
from .request import Request
from .volume import is_flat

FLAT_PERHAPS = 1e-3
"""Fraction of the rest volume below which what enters is looked at closely: that costs time, so not in every frame."""


def wanted_volume(binding: isochor.Binding, request: Request) -> float | NDArray[np.float64] | None:
    """The volume to reach: that of the reference, times the factor of the Target input. None is that of the mesh as
    bound, which the native library refuses where the mesh is flat; any other volume is refused for it here. With bodies
    it is one for each, (bodies,)."""
    if request.bodies is not None:
        return _wanted_of_bodies(binding.reference_volumes, request)
    settings, own = request.settings, binding.reference_volume
    rest = request.rest_volume if settings.reference == "Rest" else _incoming(request)
    if settings.target == 1.0 and rest in (None, own):
        return None
    _refuse_flat(request, perhaps=rest is None or abs(own) <= FLAT_PERHAPS * abs(rest))
    return (own if rest is None else rest) * settings.target


def target_volume(binding: isochor.Binding, request: Request) -> float | None:
    """Signed volume that the mesh of this request, which is in the binding, should have in all; None where it encloses
    none."""
    if request.triangles is None:
        return None
    try:
        wanted = wanted_volume(binding, request)
        return float(binding.reference_volume if wanted is None else np.sum(wanted))
    except isochor.Error:
        return None


def _wanted_of_bodies(own: NDArray[np.float64], request: Request) -> NDArray[np.float64] | None:
    settings = request.settings
    kept = rest_of_bodies(own, request) if settings.reference == "Rest" else _incoming_of_bodies(own, request)
    factors = np.full(len(own), settings.target)
    if request.bodies is not None and request.bodies.region is not None:
        factors[-1] = settings.parts.region_target
    wanted = np.asarray(kept * factors)
    if np.array_equal(wanted, own):
        return None
    _refuse_flat(request, perhaps=bool((np.abs(own) <= FLAT_PERHAPS * np.abs(kept)).all()) or kept is own)
    return wanted


def _incoming(request: Request) -> float | None:
    """Volume that entered the chain of lattices in this frame; None where it is that of what enters this one."""
    return None if request.incoming is None else float(sum(request.incoming))


def _incoming_of_bodies(own: NDArray[np.float64], request: Request) -> NDArray[np.float64]:
    known = request.incoming is not None and len(request.incoming) == len(own)
    return np.array(request.incoming, np.float64) if known else own


def _refuse_flat(request: Request, perhaps: bool) -> None:
    """Raises VolumeError where what enters encloses nothing, which costs time to see, so only where it may be."""
    if perhaps and request.triangles is not None and is_flat(request.positions, request.triangles):
        raise isochor.VolumeError(problem.FLAT)


def rest_of_bodies(own: NDArray[np.float64], request: Request) -> NDArray[np.float64]:
    """(bodies,) volumes at rest: those that are kept; where they are not known, or of another number of bodies, what
    enters now, scaled so that the whole is that at rest."""
    if request.rest_parts is not None and len(request.rest_parts) == len(own):
        return np.array(request.rest_parts, np.float64)
    whole = float(own.sum())
    if request.rest_volume is None or whole == 0.0:
        return own
    return np.asarray(own * (request.rest_volume / whole))
