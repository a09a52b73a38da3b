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


def in_no_scene(name: str) -> str:
    """The lattice was deleted from its scenes, but Blender keeps it, since a modifier refers to it."""
    return (
        f"The lattice “{name}” is in no scene, yet shapes the mesh: clear the modifier's Lattice input, or link it to a"
        f" collection."
    )


def foreign(name: str) -> str:
    """An object is linked from another file, where it cannot be changed."""
    return f"{name} comes from another file: make it local or override it first"


def modifier_of_library(name: str, modifier: str) -> str:
    """An override has this modifier from its library: taken away here, it would be back on loading."""
    return (
        f"“{modifier}” of “{name}” comes from another file: remove it there, or switch it off here (its eye and camera"
        f" buttons)."
    )


def foreign_points(name: str) -> str:
    """A lattice's points are linked from another file; in an override Blender would lose what is done to them."""
    return f"The points of “{name}” belong to another file: make its data local (Object, Relations, Make Local)."


def locked_shape_key(name: str, key: str) -> str:
    """The active shape key is locked against edits."""
    return f"The shape key “{key}” of “{name}” is locked: unlock it, or make another one active."


def no_sides(name: str, axis: str) -> str:
    """A lattice with one layer along an axis has no two sides there."""
    return f"“{name}” has one layer of points along {axis}, so no two sides: choose another axis."


def nothing_selected(name: str) -> str:
    """In Edit Mode no point of a lattice is selected."""
    return f"No point of “{name}” is selected: select some, or turn off Only Selected."


def sentence(error: Exception) -> str:
    """What an error of the native library says, as a sentence of its own."""
    text = str(error)
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"
