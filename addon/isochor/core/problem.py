# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems that are the animator's to solve, in plain words."""


class Problem(Exception):
    """Says what is wrong with the scene and what to do about it; never a fault of the program."""


NO_LATTICE = "No lattice: pick a Lattice object in the modifier's Lattice input."
NO_VERTICES = "The mesh has no vertices: add some, or remove the modifier."
NO_FACES = "The mesh has no faces, so it encloses no volume: set Preserve to 0 to deform it all the same."
FLAT = (
    "The mesh is flat, so it encloses no volume: give it thickness above Volume Lattice, as a Solidify modifier does,"
    " or set Preserve to 0 to deform it all the same."
)
EDITED = (
    "The mesh was edited since the lattice was added: Rest is its old volume. Set Reference to Incoming, or remove and"
    " add the modifier."
)


def not_a_lattice(name: str, kind: str) -> str:
    """The Lattice input holds an object of another kind (``kind`` as Blender names it, such as MESH)."""
    return f"“{name}” is a {kind.lower()}, not a lattice: pick a Lattice object in the modifier's Lattice input."


def flat_lattice(name: str) -> str:
    """The lattice's or the object's matrix cannot be inverted."""
    return f"The lattice “{name}” has a scale of zero on at least one axis: give it a size on every axis."


def flat_object(name: str) -> str:
    """The object's own matrix cannot be inverted, so the lattice cannot be expressed in its space."""
    return f"“{name}” has a scale of zero on at least one axis: give it a size on every axis."


def capped_lattice(name: str, shape: tuple[int, int, int], count: int) -> str:
    """Blender keeps fewer points than the resolution says."""
    return f"The lattice “{name}” says {shape} points but has {count}: lower its resolution to at most 64 a side."


def lost_by(names: list[str]) -> str:
    """The modifiers that follow do not keep the vertices that entered ours."""
    what = f"What comes after Volume Lattice ({', '.join(names)})" if names else "Something after Volume Lattice"
    return f"{what} replaces the vertices that enter it: move Volume Lattice below that in the modifier stack."


def faces_hidden_by(names: list[str]) -> str:
    """Modifiers both before and after ours change the faces, so those that entered cannot be read."""
    return (
        f"The volume cannot be measured, because modifiers before and after Volume Lattice both change the faces"
        f" ({', '.join(names)}): move Volume Lattice below them in the modifier stack."
    )


def between(names: list[str]) -> str:
    """Another modifier stands between two of ours; the second then lags."""
    return f"{', '.join(names)} stands between two Volume Lattice modifiers: move it above or below both of them."


def no_vertex_group(name: str) -> str:
    """The Vertex Group input names a group that the object lacks."""
    return f"There is no vertex group “{name}”: correct the name in the modifier's Vertex Group input, or clear it."


def linked(name: str) -> str:
    """The object's result meshes belong to another file, where they cannot be written."""
    return (
        f"“{name}” is linked from another file and keeps the shape that it was saved with: make a library override of"
        f" it, or make it local."
    )


def no_device(name: str) -> str:
    """The preferences name an adapter that this machine does not have."""
    return f"There is no adapter “{name}” here, so the CPU computes: choose another in the extension's preferences."


def nothing_carried(lattice: str, names: str) -> str:
    """The lattice shapes no mesh whose frame could be computed."""
    return (
        f"“{lattice}” carries no mesh that Volume Lattice could compute ({names}): correct what the sidebar says first."
    )


def no_pin_group(group: str, lattice: str) -> str:
    """The group of pinned points is missing."""
    return f"The lattice “{lattice}” has no vertex group “{group}”: correct the name under Pinned, or clear it."


def no_ground(name: str) -> str:
    """The object named as ground is not in the scene."""
    return (
        f"There is no object “{name}” in the scene: correct the name under Ground Object, or clear it for level ground."
    )


def no_frames(start: int, end: int) -> str:
    """The range of a simulation has no frame after the first."""
    return f"A simulation from frame {start} to {end} has no frame to move in: let End be greater than Start."


def from_elsewhere(names: list[str]) -> str:
    """Objects of a library."""
    return f"{', '.join(names)} comes from another file: make it local or override it first."


def in_edit_mode(names: list[str]) -> str:
    """Lattices whose points are being edited."""
    return f"{', '.join(names)} is in Edit Mode: leave it first."


def sentence(error: Exception) -> str:
    """What an error of the native library says, as a sentence of its own."""
    text = str(error)
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"
