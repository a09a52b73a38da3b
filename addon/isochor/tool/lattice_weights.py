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
    group, data = lattice.vertex_groups.get(name), lattice.data
    if group is None:
        return None
    return grid.in_order(flat(lattice, group), (data.points_u, data.points_v, data.points_w))


def flat(lattice: bpy.types.Object, group: bpy.types.VertexGroup) -> Weights:
    """The same of one of its groups, (N,), u fastest."""
    weights = np.zeros(len(lattice.data.points))
    for number, point in enumerate(lattice.data.points):
        for entry in point.groups:
            if entry.group == group.index:
                weights[number] = entry.weight
    return weights


def copy_own_group(source: bpy.types.Object, target: bpy.types.Object) -> None:
    """Gives a lattice object with as many points the vertex group that another one's data names, if any. Neither may be
    in Edit Mode."""
    name = source.data.vertex_group
    weights = of_group(source, name) if name and not source.data.is_editmode else None
    if weights is None:
        return
    group = target.vertex_groups.new(name=name)
    assign(group, weights.transpose(2, 1, 0).reshape(-1))
    target.data.vertex_group = group.name


def assign(group: bpy.types.VertexGroup, weights: Weights) -> None:
    """Puts the points of weights (N,), u fastest, into a group that has none; those of 0 stay outside."""
    for weight in np.unique(weights[weights > 0.0]):
        group.add(np.flatnonzero(weights == weight).tolist(), float(weight), "REPLACE")


@dataclass
class GroupCache:
    """The weights read last, which are read again only after an edit of the lattice. ``use``: the input that names the
    group, as the animator knows it."""

    use: str

    stamp: tuple[int, int, str] | None = None
    weights: Weights | None = field(default=None, repr=False)

    def of(self, lattice: bpy.types.Object, name: str, edits: int) -> Weights:
        """Those of the group called ``name`` of an evaluated lattice, whose data was edited so many times; in its Edit
        Mode those from before. Raises a Problem where they are not known."""
        uid = lattice.data.original.session_uid
        if lattice.data.is_editmode:
            if self.weights is None or self.stamp is None or (uid, name) != (self.stamp[0], self.stamp[2]):
                raise problem.Problem(problem.group_in_edit_mode(lattice.name, self.use))
            return self.weights
        stamp = (uid, edits, name)
        if stamp != self.stamp or self.weights is None:
            self.weights, self.stamp = of_group(lattice, name), stamp
        if self.weights is None:
            raise problem.Problem(problem.no_lattice_group(name, lattice.name, self.use))
        return self.weights
