# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lattice object keeps of the blocks that it is tied to: a custom property, face by face, which goes with it
when the file is saved, the object appended or, together with its neighbour, copied."""

from dataclasses import dataclass

import bpy

from ..core.tie import FACES

TIES = "isochor_ties"
"""Custom property of a lattice object: by the name of a face, what it is tied to."""
OTHER, OTHER_FACE, CONTINUITY, LEADS, STAMP = "lattice", "face", "continuity", "leads", "stamp"
"""In it: the other object, its face, 0 or 1, whether this side leads, and the points of this side as they were when the
two were last made to agree."""


@dataclass(frozen=True)
class Tied:
    """One tie, seen from ``lattice``, an original object."""

    lattice: bpy.types.Object
    face: str
    other: bpy.types.Object
    other_face: str
    continuity: int
    leads: bool

    @property
    def stamp(self) -> str:
        """Of this side's points when the two last agreed."""
        return str(self.lattice[TIES][self.face].get(STAMP, ""))

    @property
    def turned(self) -> "Tied":
        """The same tie, seen from the other side."""
        return Tied(self.other, self.other_face, self.lattice, self.face, self.continuity, not self.leads)


def of(lattice: bpy.types.Object) -> list[Tied]:
    """The ties of an original lattice object that hold: both sides must know of them, as a copy of one alone does not,
    and be there."""
    kept = lattice.get(TIES)
    if kept is None:
        return []
    found = [_read(lattice, face, kept[face]) for face in FACES if face in kept]
    return [tied for tied in found if tied is not None]


def is_tied(lattice: bpy.types.Object) -> bool:
    """Whether anything is kept; quick."""
    return TIES in lattice


def keep(tied: Tied) -> None:
    """Notes the tie on both objects, in place of what their faces were tied to before."""
    for side in (tied, tied.turned):
        for before in of(side.lattice):
            if before.face == side.face and before.other != side.other:
                forget(before)
    for side in (tied, tied.turned):
        kept = side.lattice.get(TIES)
        found = {} if kept is None else kept.to_dict()
        found[side.face] = {
            OTHER: side.other,
            OTHER_FACE: side.other_face,
            CONTINUITY: side.continuity,
            LEADS: side.leads,
            STAMP: "",
        }
        side.lattice[TIES] = found


def forget(tied: Tied) -> None:
    """The two are no longer tied."""
    for side in (tied, tied.turned):
        kept = side.lattice.get(TIES)
        if kept is not None and side.face in kept:
            del kept[side.face]
            if not len(kept):
                del side.lattice[TIES]


def lead(tied: Tied, leads: bool) -> None:
    """Has this side lead, or the other."""
    for side, value in ((tied, leads), (tied.turned, not leads)):
        if side.lattice.is_editable and bool(side.lattice[TIES][side.face][LEADS]) != value:
            side.lattice[TIES][side.face][LEADS] = value


def note(tied: Tied, stamp: str) -> None:
    """The points of this side are now those with this stamp, and agree with the other's."""
    if tied.lattice.is_editable and tied.stamp != stamp:
        tied.lattice[TIES][tied.face][STAMP] = stamp


def connected(lattices: list[bpy.types.Object]) -> list[bpy.types.Object]:
    """These and all that hang together with them by ties, each once."""
    found, waiting = {}, list(lattices)
    while waiting:
        lattice = waiting.pop(0)
        if lattice.session_uid not in found:
            found[lattice.session_uid] = lattice
            waiting += [tied.other for tied in of(lattice)]
    return list(found.values())


def _read(lattice: bpy.types.Object, face: str, kept: bpy.types.PropertyGroup) -> Tied | None:
    other = kept.get(OTHER)
    if not isinstance(other, bpy.types.Object) or other.type != "LATTICE" or other == lattice:
        return None
    back = other.get(TIES)
    answer = None if back is None else back.get(kept[OTHER_FACE])
    if answer is None or answer.get(OTHER) != lattice or answer[OTHER_FACE] != face:
        return None
    return Tied(lattice, face, other, kept[OTHER_FACE], int(kept[CONTINUITY]), bool(kept[LEADS]))
