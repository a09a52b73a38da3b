# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts right what Blender mixes up in rare undos and redos: a Lattice input that then names the deformed mesh itself.

Blender reads an object that an undo step changes into fresh memory, swaps it with the one there, and turns whatever in
it refers to the fresh memory into the object itself. At that moment references still hold addresses from when the step
was kept: where the fresh memory lies where the lattice, gone meanwhile, lay then, the Lattice input is taken for one.
Session identifiers stay the same across undo, so what was noted before tells the right lattice.
"""

import bpy

from . import lattices, node_group, sockets, stack

_known: dict[tuple[int, int], int] = {}
"""Session identifier of the lattice, by that of the object and the identifier of the modifier in it."""


def note() -> None:
    """Before an undo or redo: which lattice every modifier names."""
    for obj, modifier in _all():
        lattice = lattices.of(modifier)
        if lattice is not None:
            _known[obj.session_uid, modifier.persistent_uid] = lattice.session_uid


def put_right() -> None:
    """After it: a modifier that names its own object gets back the lattice that was noted, if that is there."""
    wrong = [(obj, modifier) for obj, modifier in _all() if sockets.read(modifier, sockets.LATTICE) == obj]
    if not wrong:
        return
    there = {obj.session_uid: obj for obj in bpy.data.objects if obj.type == "LATTICE"}
    for obj, modifier in wrong:
        lattice = there.get(_known.get((obj.session_uid, modifier.persistent_uid), -1))
        if lattice is not None and obj.is_editable:
            sockets.write(modifier, sockets.LATTICE, lattice)


def forget() -> None:
    """Another file: nothing that was noted belongs to it."""
    _known.clear()


def _all() -> list[lattices.Pair]:
    users = stack.users(node_group.all_groups())
    return [(obj, modifier) for obj in users for modifier in stack.ours(obj)]
