# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be wrong with pins, in plain words and with the names of the objects that hold them."""

import re
from collections.abc import Callable, Sequence

from .words import Sentence, listed, sentence

NOTHING_SELECTED = Sentence(
    "Nothing is selected to pin: select vertices or faces of the mesh in Edit Mode, or click on its surface."
)
NOTHING_TO_BIND = Sentence(
    "No pin needs to be bound: select the objects that are to hold the surface, along with the mesh."
)
NO_PINS = Sentence("There are no pins to remove.")


def no_surface(name: str) -> Sentence:
    """Curves, hair and point clouds have no surface that pins could hold."""
    return Sentence("“{name}” has no surface that pins could hold: they do nothing.", name=name)


def too_many(name: str, count: int, points: int) -> Sentence:
    """More points to pin than points of the lattice that could move for them."""
    return Sentence(
        "{count} points of “{name}” are selected, and the lattice has {points}: pin fewer of them.",
        count=count,
        name=name,
        points=points,
    )


def not_bound(names: Sequence[str]) -> Sentence:
    """Objects of the collection that hold no point of this mesh."""
    return Sentence(
        "{names}: not bound to this mesh, so nothing follows. Use Bind Pins in the sidebar tab Isochor.",
        names=listed(names),
    )


def bound_otherwise(names: Sequence[str]) -> Sentence:
    """The mesh has another number of vertices than when these were bound."""
    return Sentence(
        "{names}: bound when the mesh had other vertices, so nothing follows. Bind the pin again: Bind Pins in the"
        " sidebar tab Isochor.",
        names=listed(names),
    )


def without_faces(names: Sequence[str]) -> Sentence:
    """Points within faces, where the faces of the mesh that entered cannot be read."""
    return Sentence(
        "{names}: the pin holds a point of a face, and the faces cannot be read here. Bind it to a vertex instead.",
        names=listed(names),
    )


def no_place(names: Sequence[str]) -> Sentence:
    """Objects at infinity, or whose transform is no number."""
    return Sentence("{names}: stands nowhere (NaN or infinity). Correct its transform or driver.", names=listed(names))


def holds_itself(name: str) -> Sentence:
    """The deformed object is in its own collection of pins."""
    return Sentence("“{name}” is in its own collection of pins: take it out of it.", name=name)


def flat_pin(name: str) -> Sentence:
    """The matrix of an object that is to hold a pin cannot be inverted."""
    return Sentence("“{name}” has a scale of zero, so it can hold nothing: give it a size.", name=name)


def not_computed(name: str) -> Sentence:
    """What leaves the modifier is not known, so no point of it can be pinned."""
    return Sentence("“{name}” shows no computed shape here: first correct what the sidebar says.", name=name)


def older_file(name: str) -> Sentence:
    """The node group comes from a file of an older version, linked, without the input."""
    return Sentence(
        "The Volume Lattice of “{name}” comes from an older file and has no input {input}: open and save that file",
        name=name,
        input="Pins",
    )


def foreign_collection(name: str) -> Sentence:
    """The collection of pins cannot be changed here."""
    return Sentence("The collection “{name}” comes from another file: make it local first.", name=name)


def _same_point(names: str) -> Sentence:
    return Sentence(
        "{names} hold the same point: remove one of them, or bind it elsewhere with Bind Pins.", names=names
    )


def _torn_point(names: str) -> Sentence:
    return Sentence(
        "{names} hold the same point and pull it to different places: remove one of them, or bind it elsewhere with"
        " Bind Pins.",
        names=names,
    )


def _too_near(names: str) -> Sentence:
    return Sentence(
        "{names} are too near each other to pull so differently: remove one of them, or bring them closer together.",
        names=names,
    )


def _dependent(names: str) -> Sentence:
    return Sentence(
        "{names} cannot move apart from each other and from the other pins, because the lattice has too few points"
        " there: remove one of them, or give the lattice more points.",
        names=names,
    )


def _immovable(names: str) -> Sentence:
    return Sentence(
        "{names} holds a point that the lattice cannot move, because it is outside of it, has no weight, or the points"
        " around it are frozen: remove that pin, or fit the lattice again.",
        names=names,
    )


NUMBERS = re.compile(r"pins? (\d+)(?: and (\d+))?")
"""How the native library says which pins are in trouble."""
TROUBLES: tuple[tuple[str, Callable[[str], Sentence]], ...] = (
    ("with the same target", _same_point),
    ("with different targets", _torn_point),
    ("too near each other", _too_near),
    ("cannot move independently", _dependent),
    ("is not moved by any control point", _immovable),
)
"""Words of the native library, and the same as a sentence."""


def trouble(error: Exception, names: Sequence[str]) -> Sentence:
    """What an ``isochor.PinError`` says, with the names of the objects in place of numbers."""
    text = str(error)
    found = NUMBERS.search(text)
    numbers = [int(number) for number in found.groups() if number is not None] if found else []
    which = listed(names[number] for number in numbers if number < len(names))
    for words, said in TROUBLES:
        if words in text:
            return said(which)
    return Sentence("{names}: {text}", names=which, text=sentence(text)) if which else sentence(text)
