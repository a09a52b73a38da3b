# SPDX-License-Identifier: GPL-3.0-or-later
"""The pins of a modifier in one evaluated frame: which point of the mesh each holds, and where that must be."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import barycentric, pin_problem, problem
from ..core.pins import Pins
from . import evaluated, pin_record, sockets
from .pin_record import Place

Array = NDArray[np.float64]
Triangles = NDArray[np.int32]


@dataclass(frozen=True)
class Around:
    """What pins are read against: the deformed object's matrix to world, the depsgraph, the mesh that entered."""

    matrix: Array
    depsgraph: bpy.types.Depsgraph
    positions: NDArray[Any]
    triangles: Triangles | None
    own_count: int | None
    """Vertices of the object's own mesh, where the modifiers before keep them as the first; else None."""


@dataclass
class Corners:
    """Which triangle holds a place, found once for each array of triangles."""

    triangles: Triangles | None = field(default=None, repr=False)
    found: dict[Place, tuple[int, Array] | None] = field(default_factory=dict)

    def triangle(self, place: Place, positions: NDArray[Any], triangles: Triangles) -> tuple[int, Array] | None:
        """Index and barycentric coordinates (3,), or None where no triangle has such a corner."""
        if triangles is not self.triangles:
            self.triangles, self.found = triangles, {}
        if place not in self.found:
            self.found[place] = _triangle(place, positions, triangles)
        return self.found[place]


class _Held(NamedTuple):
    """One pin: the name of the object that holds it, the place in the mesh that entered, the target in the world."""

    name: str
    place: Place
    target: Array


def collection(modifier: bpy.types.NodesModifier) -> bpy.types.Collection | None:
    """What the input Pins names; a group linked from a file older than that has none."""
    if sockets.PINS not in sockets.identifiers(modifier.node_group):
        return None
    found: bpy.types.Collection | None = sockets.read(modifier, sockets.PINS)
    return found


def objects(modifier: bpy.types.NodesModifier) -> list[bpy.types.Object]:
    """Every object in the modifier's collection of pins and in those below it, but the deformed one."""
    held = collection(modifier)
    return [] if held is None else [obj for obj in held.all_objects if obj != modifier.id_data]


def read(
    modifier: bpy.types.NodesModifier, mode: str, around: Around, corners: Corners
) -> tuple[Pins | None, list[str]]:
    """The pins, or None where there are none, and what is wrong with others. ``modifier`` is original."""
    held = collection(modifier)
    if held is None:
        return None, []
    mark, problems = pin_record.mark_of(modifier, mode), _Problems()
    if modifier.id_data.name in held.all_objects:
        problems.other.append(pin_problem.holds_itself(modifier.id_data.name))
    read_ones = [_read_one(obj, mark, around, problems) for obj in objects(modifier)]
    found = [one for one in read_ones if one is not None]
    if any(not one.place.is_vertex for one in found):
        return _within_faces(found, around, corners, problems), problems.texts()
    return _of_vertices(found, around), problems.texts()


@dataclass
class _Problems:
    """Names of the objects in trouble, by what is wrong with them."""

    not_bound: list[str] = field(default_factory=list)
    bound_otherwise: list[str] = field(default_factory=list)
    no_place: list[str] = field(default_factory=list)
    without_faces: list[str] = field(default_factory=list)
    other: list[str] = field(default_factory=list)

    def texts(self) -> list[str]:
        """A sentence for each kind of trouble that there is."""
        kinds = (
            (pin_problem.not_bound, self.not_bound),
            (pin_problem.bound_otherwise, self.bound_otherwise),
            (pin_problem.no_place, self.no_place),
            (pin_problem.without_faces, self.without_faces),
        )
        return [*self.other, *(said(names) for said, names in kinds if names)]


def _read_one(obj: bpy.types.Object, mark: str, around: Around, problems: _Problems) -> _Held | None:
    record = pin_record.read(obj, mark)
    if record is None:
        problems.not_bound.append(obj.name)
        return None
    place = record.place(len(around.positions), around.own_count)
    if place is None or max(place.corners) >= len(around.positions):
        problems.bound_otherwise.append(obj.name)
        return None
    held = obj.evaluated_get(around.depsgraph)
    if not held.is_evaluated:
        problems.other.append(problem.hidden(obj.name))
        return None
    matrix = evaluated.matrix(held)
    target = matrix[:3, :3] @ np.array(record.offset) + matrix[:3, 3]
    if not np.isfinite(target).all():
        problems.no_place.append(obj.name)
        return None
    return _Held(obj.name, place, target)


def _of_vertices(found: list[_Held], around: Around) -> Pins | None:
    """All of them in arrays, each a vertex."""
    corners = np.array([one.place.corners for one in found], np.int32).reshape(-1, 3)
    weights = np.array([one.place.weights for one in found], np.float64).reshape(-1, 3)
    return _in_arrays(found, corners, weights, None, around)


def _within_faces(found: list[_Held], around: Around, corners: Corners, problems: _Problems) -> Pins | None:
    """All of them in arrays, each in terms of a triangle; where there are none, those that are vertices."""
    triangles = around.triangles
    if triangles is None:
        problems.without_faces += [one.name for one in found if not one.place.is_vertex]
        return _of_vertices([one for one in found if one.place.is_vertex], around)
    where = [(one, corners.triangle(one.place, around.positions, triangles)) for one in found]
    problems.without_faces += [one.name for one, at in where if at is None]
    known = [(one, *at) for one, at in where if at is not None]
    indices = np.array([index for _one, index, _weights in known], np.int64)
    weights = np.array([given for _one, _index, given in known], np.float64).reshape(-1, 3)
    return _in_arrays([one for one, *_at in known], triangles[indices], weights, indices, around)


def _in_arrays(
    found: list[_Held],
    corners: NDArray[np.int32],
    weights: Array,
    triangles: NDArray[np.int64] | None,
    around: Around,
) -> Pins | None:
    if not found:
        return None
    inverse = np.linalg.inv(around.matrix)
    targets = np.array([one.target for one in found]) @ inverse[:3, :3].T + inverse[:3, 3]
    names = tuple(one.name for one in found)
    return Pins(names, corners, weights, triangles, targets, around.matrix[:3, :3].copy())


def _triangle(place: Place, positions: NDArray[Any], triangles: Triangles) -> tuple[int, Array] | None:
    """The triangle with these corners; where there is none, as where a face is cut otherwise than when the pin was
    bound, the nearest of those with one of them."""
    shares = [np.isin(triangles, corner).any(axis=1) for corner in set(place.corners)]
    for index in np.flatnonzero(np.all(shares, axis=0))[:1]:
        return int(index), _weights_in(place, triangles[index])
    some = np.flatnonzero(np.any(shares, axis=0))
    if not len(some):
        return None
    point = barycentric.places(positions, np.array([place.corners]), np.array([place.weights]))[0]
    near, weights = barycentric.nearest(point, positions[triangles[some]].astype(np.float64))
    return int(some[near]), weights


def _weights_in(place: Place, triangle: NDArray[np.int32]) -> Array:
    """(3,) the weights of the place in the order in which the triangle has its corners."""
    of_corner: dict[int, float] = {}
    for corner, weight in zip(place.corners, place.weights, strict=True):
        of_corner[corner] = of_corner.get(corner, 0.0) + weight
    return np.array([of_corner.get(int(corner), 0.0) for corner in triangle])
