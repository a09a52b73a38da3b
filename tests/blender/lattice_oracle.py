# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lattice does to points, written anew in numpy from the textbook: no code is shared with the extension."""

from math import comb

import bpy
import numpy as np
from numpy.typing import NDArray


def deformed(obj: bpy.types.Object, lattice: bpy.types.Object, points: NDArray[np.float64], basis: str) -> NDArray:
    """Points (V, 3) of the object's space as the evaluated lattice moves them, those outside its domain unmoved."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    held = lattice.evaluated_get(depsgraph)
    to_object = np.linalg.inv(np.array(obj.evaluated_get(depsgraph).matrix_world, np.float64)) @ np.array(
        held.matrix_world, np.float64
    )
    count = (held.data.points_u, held.data.points_v, held.data.points_w)
    control = np.array([point.co_deform for point in held.data.points], np.float64)
    control = control.reshape(count[2], count[1], count[0], 3)
    inside = (points - to_object[:3, 3]) @ np.linalg.inv(to_object[:3, :3]).T + 0.5
    weights, held_by_all = [], np.ones(len(points), bool)
    for axis in range(3):
        found, is_inside = axis_weights(inside[:, axis], count[axis], basis)
        weights.append(found)
        held_by_all &= is_inside
    moved = np.einsum("pi,pj,pk,kjic->pc", *weights, control) @ to_object[:3, :3].T + to_object[:3, 3]
    return np.where(held_by_all[:, None], moved, points)


def axis_weights(unit: NDArray[np.float64], count: int, basis: str) -> tuple[NDArray, NDArray]:
    """(V, count) weights at coordinates over [0, 1] of the grid, and whether each is in the basis's domain."""
    if basis == "Bernstein":
        degree = count - 1
        found = [comb(degree, i) * unit**i * (1 - unit) ** (degree - i) for i in range(count)]
        return np.stack(found, axis=-1), (unit >= -1e-9) & (unit <= 1 + 1e-9)
    place = unit * (count - 1)
    centred = place[:, None] - np.arange(count)
    return cubic_bump(centred), (place >= 1 - 1e-9) & (place <= count - 2 + 1e-9)


def cubic_bump(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cardinal cubic B-spline, of support [-2, 2]."""
    size = np.abs(x)
    near = 2 / 3 - size**2 + size**3 / 2
    far = (2 - size) ** 3 / 6
    return np.where(size < 1, near, np.where(size < 2, far, 0.0))
