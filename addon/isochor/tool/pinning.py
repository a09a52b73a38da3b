# SPDX-License-Identifier: GPL-3.0-or-later
"""Binding objects to points of a surface, from where both stand now."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import barycentric, pin_problem, problem
from . import adding, evaluated, pin_collection, pin_record, pins, rest, results, stack, state
from .lattices import Pair
from .pin_record import Place, Record

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """What a modifier was given last and what left it, (V, 3) in the object's own space, and the triangles (F, 3) of
    both, or None where they are not known; ``matrix`` to world."""

    entered: NDArray[Any]
    left: NDArray[Any]
    triangles: NDArray[np.int32] | None
    matrix: Array

    def vertex(self, index: int) -> "Point":
        """One of its vertices."""
        return self.at(pin_record.vertex(index))

    def nearest(self, world: Array) -> "Point":
        """The point of what left that is nearest, in the world, to one in the world."""
        return self.at(self._place(self.left @ self.matrix[:3, :3].T + self.matrix[:3, 3], world))

    def place_at_rest(self, point: Array) -> Place:
        """The place of what entered that is nearest to a point in the object's own space."""
        return self._place(self.entered, point)

    def at(self, place: Place) -> "Point":
        """The point at a place."""
        corners, weights = np.array([place.corners], np.int32), np.array([place.weights])
        at_rest, left = (barycentric.places(vertices, corners, weights)[0] for vertices in (self.entered, self.left))
        return Point(place, at_rest, self.matrix[:3, :3] @ left + self.matrix[:3, 3])

    def snapped(self, point: "Point") -> "Point":
        """The nearest corner of the triangle that a point is in."""
        return self.vertex(point.place.corners[int(np.argmax(point.place.weights))])

    def _place(self, vertices: NDArray[Any], point: Array) -> Place:
        if self.triangles is None or not len(self.triangles):
            ways = vertices.astype(np.float64) - point
            return pin_record.vertex(int(np.argmin(np.einsum("ij,ij->i", ways, ways))))
        index, weights = barycentric.nearest(point, vertices[self.triangles].astype(np.float64))
        return pin_record.place(self.triangles[index], weights)


class Point(NamedTuple):
    """A point of the surface: its place, where it is in what entered (object space), and where it shows (world)."""

    place: Place
    rest: Array
    world: Array


def shape_of(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> Shape:
    """The shape that the viewport shows of the modifier; raises ``Problem`` where none was computed."""
    memory, shown = state.recall(obj, modifier), obj.evaluated_get(depsgraph)
    if not shown.is_evaluated:
        raise problem.Problem(problem.hidden(obj.name))
    entered = None if memory is None else memory.solver.entered
    left = None if memory is None or memory.written is None else memory.written.vertices
    is_on = modifier in stack.active(obj, "VIEWPORT")
    if memory is None or entered is None or left is None or len(left) != len(entered) or not is_on:
        raise problem.Problem(pin_problem.not_computed(obj.name))
    return Shape(entered, left, memory.faces.triangles, evaluated.matrix(shown))


def add(pair: Pair, points: list[Point], follow: bool, context: bpy.types.Context) -> list[bpy.types.Object]:
    """Makes an empty at each point and has it hold that; returns the empties. Raises ``Problem`` before it changes
    anything."""
    obj, modifier = pair
    pin_collection.refuse(obj, modifier)
    all_places = _places(pair, points, context.view_layer)
    results.ensure_own()
    held, mark = pin_collection.ensure(obj, modifier, context.scene), pin_record.ensure_mark(modifier)
    made = []
    for point, places in zip(points, all_places, strict=True):
        empty = pin_collection.new_empty(obj, held, point.world, context)
        pin_record.keep(empty, mark, Record((0.0, 0.0, 0.0), _triple(point.rest), places))
        made.append(empty)
    if follow:
        for empty in made:
            adding.make_child(empty, obj)
    obj.update_tag()
    return made


def bind(pair: Pair, holders: list[bpy.types.Object], anew: bool, context: bpy.types.Context) -> None:
    """Has each object hold a point of the surface: the one that it held, where the mesh has other vertices since
    (unless ``anew``), or the one nearest to it now, which stays where it is and from now on goes along with the object.
    Raises ``Problem`` before it changes anything."""
    obj, modifier = pair
    pin_collection.refuse(obj, modifier)
    depsgraph = context.evaluated_depsgraph_get()
    mark, shape = pin_record.mark_of(modifier), shape_of(obj, modifier, depsgraph)
    found = [_bound(holder, mark, shape, own_count(obj, modifier), anew, depsgraph) for holder in holders]
    all_places = _places(pair, [point for point, _offset in found], context.view_layer)
    results.ensure_own()
    held, mark = pin_collection.ensure(obj, modifier, context.scene), pin_record.ensure_mark(modifier)
    for holder, (point, offset), places in zip(holders, found, all_places, strict=True):
        pin_collection.put_in(held, holder)
        pin_record.keep(holder, mark, Record(_triple(offset), _triple(point.rest), places))
    obj.update_tag()


def own_count(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> int | None:
    """Vertices of the object's own mesh, where they are the first of those that enter; None where not, or where the
    modifier is off."""
    active = stack.active(obj, "VIEWPORT")
    return len(obj.data.vertices) if modifier in active and stack.keeps_own_vertices(active, modifier) else None


def in_need(pair: Pair) -> list[bpy.types.Object]:
    """Objects in the modifier's collection that hold no point of the mesh as it is now."""
    obj, modifier = pair
    mark, memory = pin_record.mark_of(modifier), state.recall(obj, modifier)
    entered = None if memory is None else memory.solver.entered
    count = len(obj.data.vertices) if entered is None else len(entered)
    found = []
    for holder in pins.objects(modifier):
        record = pin_record.read(holder, mark)
        if record is None or record.place(count, own_count(obj, modifier)) is None:
            found.append(holder)
    return found


def _bound(
    holder: bpy.types.Object,
    mark: str,
    shape: Shape,
    own: int | None,
    anew: bool,
    depsgraph: bpy.types.Depsgraph,
) -> tuple[Point, Array]:
    """The point that the object is to hold, and where that is seen from the object."""
    if not holder.is_editable or holder.override_library is not None:
        raise problem.Problem(problem.foreign(holder.name))
    known = pin_record.read(holder, mark)
    if known is not None and not anew and known.place(len(shape.entered), own) is None:
        return shape.at(shape.place_at_rest(np.array(known.rest))), np.array(known.offset)
    seen = holder.evaluated_get(depsgraph)
    if not seen.is_evaluated:
        raise problem.Problem(problem.hidden(holder.name))
    matrix = evaluated.matrix(seen)
    if np.linalg.matrix_rank(matrix[:3, :3]) < 3:
        raise problem.Problem(pin_problem.flat_pin(holder.name))
    point = shape.nearest(matrix[:3, 3])
    return point, np.asarray(np.linalg.solve(matrix[:3, :3], point.world - matrix[:3, 3]), np.float64)


def _places(pair: Pair, points: list[Point], view_layer: bpy.types.ViewLayer) -> list[dict[str, Place]]:
    """The place of each point in the viewport's mesh and, where another enters in renders, in that."""
    obj, modifier = pair
    own, count = own_count(obj, modifier), _entering_count(obj, modifier)
    found = [_names(point.place, count, own) for point in points]
    differing = stack.differing_before(obj, modifier)
    if not differing:
        return found
    with rest.viewport_as_render(differing):
        view_layer.update()
        there = shape_of(obj, modifier, view_layer.depsgraph)
        for point, names in zip(points, found, strict=True):
            if f"{pin_record.OWN}{own}" not in names:
                names.setdefault(str(len(there.entered)), there.place_at_rest(point.rest))
    view_layer.update()
    return found


def _names(place: Place, count: int, own: int | None) -> dict[str, Place]:
    """The place by what it is looked up by."""
    found = {str(count): place}
    if own is not None and place.is_vertex and place.corners[0] < own:
        found[f"{pin_record.OWN}{own}"] = place
    return found


def _entering_count(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> int:
    memory = state.recall(obj, modifier)
    entered = None if memory is None else memory.solver.entered
    if entered is None:
        raise problem.Problem(pin_problem.not_computed(obj.name))
    return len(entered)


def _triple(numbers: Array) -> tuple[float, float, float]:
    x, y, z = numbers.tolist()
    return x, y, z
