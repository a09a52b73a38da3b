# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object that is a pin keeps of the points that it holds: a custom property, which goes along with the object
through renaming, saving, copying, appending.

A modifier and its pins know each other by a mark that the modifier's result objects carry. A copy of a deformed object
carries the same one, so the same pins hold the copy too. A point is named by vertices of the mesh that enters the
modifier, once for each number of vertices that it may have: a render's subdivision makes another than the viewport's.
"""

from secrets import token_hex
from typing import NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from . import results

MARK = "isochor_pins_mark"
"""Custom property of a result object: what the records of its pins are kept under."""
RECORDS = "isochor_pins"
"""Custom property of an object that is a pin: its records, by mark."""
OFFSET, REST, PLACES, OWN = "offset", "rest", "places", "own "

Array = NDArray[np.float64]


class Place(NamedTuple):
    """A point of a mesh: three corners with weights; a vertex is its own three corners."""

    corners: tuple[int, int, int]
    weights: tuple[float, float, float]

    @property
    def is_vertex(self) -> bool:
        """Whether it is one vertex, and not a point of a face."""
        return self.corners[0] == self.corners[1] == self.corners[2]


class Record(NamedTuple):
    """``offset``: where the held point is seen from the object that holds it, in that object's own space; ``rest``:
    where it was in the mesh that entered when it was bound; ``places`` by number of vertices, or ``OWN`` and the number
    that the object's own mesh has, for a vertex of that which all modifiers before ours keep."""

    offset: tuple[float, float, float]
    rest: tuple[float, float, float]
    places: dict[str, Place]

    def place(self, count: int, own: int | None) -> Place | None:
        """In a mesh of so many vertices; ``own``: those of the object's own mesh, where modifiers before kept them."""
        return self.places.get(str(count)) or (None if own is None else self.places.get(f"{OWN}{own}"))


def vertex(index: int) -> Place:
    """The place of a vertex."""
    return Place((index, index, index), (1.0, 0.0, 0.0))


def place(corners: NDArray[np.int32], weights: Array) -> Place:
    """A point of a triangle with these corners, which may be one of them."""
    largest = int(np.argmax(weights))
    if weights[largest] == 1.0:
        return vertex(int(corners[largest]))
    (i, j, k), (a, b, c) = corners.tolist(), weights.tolist()
    return Place((i, j, k), (a, b, c))


def mark_of(modifier: bpy.types.NodesModifier, mode: str = "VIEWPORT") -> str:
    """What the modifier's pins know it by; empty where it never had any."""
    result = results.of(modifier, mode)
    return "" if result is None else str(result.get(MARK, ""))


def ensure_mark(modifier: bpy.types.NodesModifier) -> str:
    """The same, made where there is none. The modifier must have result objects that can be written."""
    found = mark_of(modifier) or token_hex(8)
    for mode in results.INPUT_OF_MODE:
        result = results.of(modifier, mode)
        if result is not None:
            result[MARK] = found
    return found


def read(obj: bpy.types.Object, mark: str) -> Record | None:
    """What the object holds of the modifier with this mark."""
    kept = obj.get(RECORDS)
    found = None if kept is None or not mark else kept.get(mark)
    if found is None:
        return None
    places = {}
    for key, numbers in found[PLACES].items():
        i, j, k, a, b, c = numbers
        places[key] = Place((int(i), int(j), int(k)), (a, b, c))
    return Record(tuple(found[OFFSET]), tuple(found[REST]), places)


def keep(obj: bpy.types.Object, mark: str, record: Record) -> None:
    """Has the object hold this, in place of what it held of that modifier before."""
    if RECORDS not in obj:
        obj[RECORDS] = {}
    places = {key: [*map(float, place.corners), *place.weights] for key, place in record.places.items()}
    obj[RECORDS][mark] = {OFFSET: list(record.offset), REST: list(record.rest), PLACES: places}


def forget(obj: bpy.types.Object, mark: str) -> None:
    """The object no longer holds anything of that modifier."""
    kept = obj.get(RECORDS)
    if kept is None:
        return
    if mark in kept:
        del kept[mark]
    if not len(kept):
        del obj[RECORDS]
