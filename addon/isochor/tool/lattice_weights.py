# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of a lattice's points in one of its vertex groups."""

from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import grid, problem

Weights = NDArray[np.float64]


def of_group(lattice: bpy.types.Object, name: str) -> Weights | None:
    """(nu, nv, nw) in [0, 1], 0 for points outside the group; None where there is no group of that name. Not in the
    lattice's Edit Mode, in which Blender reads the groups of points from the wrong place and crashes."""
    group = lattice.vertex_groups.get(name)
    if group is None:
        return None
    data = lattice.data
    weights = np.zeros(len(data.points))
    for number, point in enumerate(data.points):
        for entry in point.groups:
            if entry.group == group.index:
                weights[number] = entry.weight
    return grid.in_order(weights, (data.points_u, data.points_v, data.points_w))


@dataclass
class StiffnessCache:
    """The weights read last, which are read again only after an edit of the lattice."""

    stamp: tuple[int, int, str] | None = None
    weights: Weights | None = field(default=None, repr=False)

    def of(self, lattice: bpy.types.Object, name: str, edits: int) -> Weights:
        """Those of the group called ``name`` of an evaluated lattice, whose data was edited so many times; in its Edit
        Mode those from before. Raises a Problem where they are not known."""
        uid = lattice.data.original.session_uid
        if lattice.data.is_editmode:
            if self.weights is None or self.stamp is None or (uid, name) != (self.stamp[0], self.stamp[2]):
                raise problem.Problem(problem.stiffness_in_edit_mode(lattice.name))
            return self.weights
        stamp = (uid, edits, name)
        if stamp != self.stamp or self.weights is None:
            self.weights, self.stamp = of_group(lattice, name), stamp
        if self.weights is None:
            raise problem.Problem(problem.no_stiffness_group(name, lattice.name))
        return self.weights
