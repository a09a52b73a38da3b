# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame of one modifier, asked for anew on a mesh whose faces were split, and which of its edges are still bent."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import isochor

from .grid import build_lattice
from .request import Request
from .solver import OUTSIDES, Outcome, Solver
from .targets import rest_of_bodies

Indices = NDArray[np.int32]
ALL_IN = 0.999
"""Share of a split vertex' parents in the region from which on it is: all of them."""


@dataclass(frozen=True)
class Split:
    """The mesh as it is: (V, 3) float32 positions, (V,) influence, (V,) in [0, 1] how much of a vertex is in the region
    (each None where the first request has none), (F, 3) triangles."""

    positions: NDArray[np.float32] = field(repr=False)
    influence: NDArray[np.float32] | None = field(repr=False)
    region: NDArray[np.float32] | None = field(repr=False)
    triangles: Indices | None = field(repr=False)


def solved(first: Request, own: NDArray[np.float64] | None, split: Split) -> tuple[Request, Outcome]:
    """What ``first``, a request for the mesh before, asks of the split one; the volumes to keep are those of before,
    ``own`` (bodies,) what enclosed there, or None where nothing is."""
    bodies = first.bodies
    if bodies is not None and split.region is not None:
        bodies = replace(bodies, region=split.region > ALL_IN)
    changed: dict[str, Any] = {"positions": split.positions, "influence": split.influence, "bodies": bodies}
    if own is not None:
        volumes = rest_of_bodies(own, first)
        changed["rest_volume"] = float(own.sum()) if first.rest_volume is None else first.rest_volume
        changed["rest_parts"] = tuple(map(float, volumes)) if bodies is not None else None
        changed["incoming"] = tuple(map(float, own)) if first.incoming is None else first.incoming
    if first.triangles is not None:
        changed["triangles"] = split.triangles
    request = replace(first, **changed)
    return request, Solver().solve(request)


def bent(request: Request, control: NDArray[np.float64], tolerance: float, edges: Indices) -> NDArray[np.bool_]:
    """(E,) which pairs (E, 2) of vertices the deformation joins by a curve that is farther than ``tolerance`` from
    straight; in units of the object's space."""
    found = isochor.bent_edges(
        build_lattice(request.embedding_grid),
        request.positions,
        edges,
        control,
        tolerance,
        outside=OUTSIDES[request.settings.outside],
        influence=request.influence,
        rest=request.rest_control,
    )
    return np.asarray(found, np.bool_)
