# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems that are the animator's to solve, in plain words."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kinds import Kind
from .words import Sentence, listed, together


class Problem(Exception):
    """Says what is wrong with the scene and what to do about it; never a fault of the program."""

    @property
    def sentence(self) -> str:
        """The same as text, which can be translated where it is a ``Sentence``."""
        return str(self.args[0])


NO_LATTICE = "No lattice: pick a Lattice object in the modifier's Lattice input."
NO_FRAME = (
    "Space is Custom, but there is no object under Frame: pick one, or choose another Space. Until then the world's"
    " axes count."
)
NO_VERTICES = "The mesh has no vertices: add some, or remove the modifier."
NO_FACES = "The mesh has no faces, so it encloses no volume: set Preserve to 0 to deform it all the same."
FLAT = (
    "The mesh is flat, so it encloses no volume: give it thickness above Volume Lattice, as a Solidify modifier does,"
    " or set Preserve to 0 to deform it all the same."
)
FLAT_PART = (
    "A part that is to keep a volume of its own is flat and encloses none: give the Region more faces, or faces that"
    " are not all in one plane."
)
NO_ISLAND = (
    "Islands: no piece of the mesh is closed and encloses a volume. Fill the holes, turn on Close Holes, or turn"
    " Islands off."
)
EDITED = (
    "The mesh was edited since the lattice was added or bound: Rest is its old volume. Fit the lattice again, bind"
    " again with Set Rest, or set Reference to Incoming."
)
INSIDE_OUT = "The mesh, or a part of it, is inside out: its volume counts as negative, and is kept all the same."
FOLDED = (
    "The lattice folds over itself: Folds in the panel Overlay shows where. Move its points apart there, or squash,"
    " twist and bend it less."
)
PERHAPS_FOLDED = (
    "Whether the lattice folds over itself cannot be told: somewhere it is pressed flat, or all but. Folds in the panel"
    " Overlay shows where."
)
NO_SURFACE = "Curves and points enclose no volume: they are deformed as the lattice says, and Preserve does nothing."
NOT_WELDED = (
    "Faces of a text or a curve are not joined where they meet: put a Weld modifier above Volume Lattice, and the"
    " volume is kept."
)
NO_POINTS = "There are no vertices to fit a lattice to: select a mesh that has some"
NO_PLACE = "Some vertices have no place (NaN or infinity): correct or delete them first"


def not_a_lattice(name: str, kind: str) -> str:
    """The Lattice input holds an object of another kind (``kind`` as Blender names it, such as MESH)."""
    return Sentence(
        "“{name}” is a {kind}, not a lattice: pick a Lattice object in the modifier's Lattice input.",
        name=name,
        kind=Kind(kind),
    )


def flat_lattice(name: str) -> str:
    """The lattice's or the object's matrix cannot be inverted."""
    return Sentence(
        "The lattice “{name}” has a scale of zero on at least one axis: give it a size on every axis.",
        name=name,
    )


def flat_shape(name: str) -> str:
    """The lattice's points lie in one plane, or in less."""
    return Sentence(
        "The lattice “{name}” is pressed flat, so nothing is inside it: give its points some depth first.", name=name
    )


def bound_otherwise(bound: tuple[int, int, int], name: str, now: tuple[int, int, int]) -> str:
    """The lattice has another resolution than when the rest was set."""
    then, today = ("×".join(map(str, shape)) for shape in (bound, now))
    return Sentence(
        "Bound with {then} points, and the lattice “{name}” now has {today}: bind again with Set Rest, or unbind with"
        " Clear Rest, in the sidebar tab Isochor.",
        then=then,
        name=name,
        today=today,
    )


def hidden(name: str) -> str:
    """Blender does not evaluate the object, as where it or its collection is hidden or excluded."""
    return Sentence("“{name}” is hidden or excluded here, so its place is not known: show it first.", name=name)


def flat_object(name: str) -> str:
    """The object's own matrix cannot be inverted, so the lattice cannot be expressed in its space."""
    return Sentence("“{name}” has a scale of zero on at least one axis: give it a size on every axis.", name=name)


def capped_lattice(name: str, shape: tuple[int, int, int], count: int) -> str:
    """Blender keeps fewer points than the resolution says."""
    return Sentence(
        "The lattice “{name}” says {shape} points but has {count}: lower its resolution to at most 64 a side.",
        name=name,
        shape=shape,
        count=count,
    )


def lost_by(names: list[str]) -> str:
    """The modifiers that follow do not keep the vertices that entered ours."""
    if not names:
        return (
            "Something after Volume Lattice replaces the vertices that enter it: move Volume Lattice below that in the"
            " modifier stack."
        )
    return Sentence(
        "What comes after Volume Lattice ({names}) replaces the vertices that enter it: move Volume Lattice below that"
        " in the modifier stack.",
        names=", ".join(names),
    )


def faces_hidden_by(names: list[str]) -> str:
    """Modifiers both before and after ours change the faces, so those that entered cannot be read."""
    return Sentence(
        "The volume cannot be measured, because modifiers before and after Volume Lattice both change the"
        " faces ({names}): move Volume Lattice below them in the modifier stack.",
        names=", ".join(names),
    )


def between(names: list[str]) -> str:
    """Another modifier stands between two of ours; the second then lags."""
    return Sentence(
        "{names} stands between two Volume Lattice modifiers: move it above or below both of them.",
        names=", ".join(names),
    )


def corrected_again(name: str) -> str:
    """A later one of several Volume Lattices, of this name, corrects too."""
    return Sentence(
        "“{name}” further down corrects the volume again, and that alone is exact for all: Preserve can be 0 here.",
        name=name,
    )


def last_leaves(name: str) -> str:
    """The last of several Volume Lattices does not correct, though one before it does."""
    return Sentence(
        "“{name}” is the last and does not correct: what it adds or takes of the volume stays so. Set Preserve to 1"
        " here rather than further up.",
        name=name,
    )


def no_vertex_group(name: str) -> str:
    """The Vertex Group input names a group that the object lacks."""
    return Sentence(
        "There is no vertex group “{name}”: correct the name in the modifier's Vertex Group input, or clear it.",
        name=name,
    )


def fell_back(asked: str, ran: str) -> str:
    """Another method computed than the one asked for."""
    return Sentence(
        "{asked} finds no way to the volume in this frame, so {ran} was taken.",
        asked=Sentence(asked),
        ran=Sentence(ran),
    )


def would_fold(missing: float, share: float) -> str:
    """The correction stopped where it would have folded space; so much volume, that share of the target, is missing."""
    return Sentence(
        "Unfolded: the correction stops where it would turn space inside out; {missing} of the volume ({percent} %) is"
        " missing.",
        missing=f"{missing:.4g}",
        percent=f"{100.0 * share:.2g}",
    )


def no_region(name: str) -> str:
    """The Region input names a group that the mesh lacks."""
    return Sentence(
        "There is no vertex group “{name}”: correct the name in the modifier's Region input, or clear it.", name=name
    )


def empty_region(name: str) -> str:
    """No face lies in the group of the Region input."""
    return Sentence(
        "No face lies in the region “{name}”: give the vertices of at least one face a weight of 0.5 or more.",
        name=name,
    )


def no_stiffness_group(name: str, lattice: str) -> str:
    """The Stiffness input names a group that the lattice lacks."""
    return Sentence(
        "The lattice “{lattice}” has no vertex group “{name}”: correct the name in the modifier's Stiffness input, or"
        " clear it.",
        name=name,
        lattice=lattice,
    )


def stiffness_in_edit_mode(lattice: str) -> str:
    """Blender does not tell the groups of points of a lattice in Edit Mode."""
    return Sentence(
        "The Stiffness of “{lattice}” is read again when you leave its Edit Mode; until then all points are free.",
        lattice=lattice,
    )


def flat_frame(name: str) -> str:
    """The matrix of the object whose axes count cannot be inverted."""
    return Sentence(
        "The Frame “{name}” has a scale of zero on at least one axis: give it a size on every axis. Until then the"
        " world's axes count.",
        name=name,
    )


def not_finite(names: list[str]) -> str:
    """Inputs of the panel Animate that hold infinity or no number at all."""
    return Sentence(
        "{names}: no finite number. Correct the driver or the keys, or type a value.", names=", ".join(names)
    )


def in_edit_mode_of_mesh() -> str:
    """The mesh is in Edit Mode, where Blender does not tell what enters a modifier."""
    return Sentence("In Edit Mode the mesh shows the shape from before: it is computed again when you leave it.")


def left_behind(lattice: str, name: str) -> str:
    """The lattice stays where it is when the object of this name moves."""
    return Sentence(
        "The lattice “{lattice}” does not move along with “{name}”, which then slides through it: make it a child of"
        " “{name}”, or both children of one parent",
        lattice=lattice,
        name=name,
    )


def drawn_otherwise(count: int, share: float) -> str:
    """Blender cuts so many quads along the other diagonal, and draws so much more of the volume (a fraction)."""
    return Sentence(
        "Blender draws {count} of the quads cut along the other diagonal, and with them a volume that is {percent} %"
        " off: put a Triangulate modifier above Volume Lattice where that matters.",
        count=count,
        percent=f"{100.0 * share:+.2g}",
    )


def linked(name: str) -> str:
    """The object's result meshes belong to another file, where they cannot be written."""
    return Sentence(
        "“{name}” is linked from another file and keeps the shape that it was saved with: make a library"
        " override of it, or make it local.",
        name=name,
    )


def no_device(name: str) -> str:
    """The preferences name an adapter that this machine does not have."""
    return Sentence(
        "There is no adapter “{name}” here, so the CPU computes: choose another in the extension's preferences.",
        name=name,
    )


def in_no_scene(name: str) -> str:
    """The lattice was deleted from its scenes, but Blender keeps it, since a modifier refers to it."""
    return Sentence(
        "The lattice “{name}” is in no scene, yet shapes the mesh: clear the modifier's Lattice input, or"
        " link it to a collection.",
        name=name,
    )


def foreign(name: str) -> str:
    """An object is linked from another file, where it cannot be changed."""
    return Sentence("{name} comes from another file: make it local or override it first", name=name)


def modifier_of_library(name: str, modifier: str) -> str:
    """An override has this modifier from its library: taken away here, it would be back on loading."""
    return Sentence(
        "“{modifier}” of “{name}” comes from another file: remove it there, or switch it off here (its eye"
        " and camera buttons).",
        modifier=modifier,
        name=name,
    )


def foreign_points(name: str) -> str:
    """A lattice's points are linked from another file; in an override Blender would lose what is done to them."""
    return Sentence(
        "The points of “{name}” belong to another file: make its data local (Object, Relations, Make Local).",
        name=name,
    )


def locked_shape_key(name: str, key: str) -> str:
    """The active shape key is locked against edits."""
    return Sentence(
        "The shape key “{key}” of “{name}” is locked: unlock it, or make another one active.",
        key=key,
        name=name,
    )


def no_sides(name: str, axis: str) -> str:
    """A lattice with one layer along an axis has no two sides there."""
    return Sentence(
        "“{name}” has one layer of points along {axis}, so no two sides: choose another axis.",
        name=name,
        axis=axis,
    )


def only_meshes(name: str, kind: str) -> str:
    """What is done to a mesh's own vertices or surface cannot be done to another kind of object."""
    return Sentence(
        "“{name}” is a {kind}, and this works on meshes: convert it first (Object, Convert, Mesh).",
        name=name,
        kind=Kind(kind),
    )


def nothing_selected(name: str) -> str:
    """In Edit Mode no point of a lattice is selected."""
    return Sentence("No point of “{name}” is selected: select some, or turn off Only Selected.", name=name)


def bound_to(name: str, users: list[str]) -> str:
    """Meshes whose rest was set would move with the lattice, instead of getting a box that fits."""
    return Sentence(
        "{users}: the rest with “{name}” was set, so moving that would move the mesh. Clear Rest first, and set it"
        " again afterwards.",
        users=", ".join(users),
        name=name,
    )


def constrained(name: str, constraints: list[str]) -> str:
    """Constraints decide where a lattice object stands."""
    return Sentence(
        "“{name}” is held by constraints ({constraints}): remove or disable them before fitting it again.",
        name=name,
        constraints=", ".join(constraints),
    )


def animated_transform(name: str, paths: list[str]) -> str:
    """Keys or drivers decide where a lattice object stands."""
    return Sentence(
        "The transform of “{name}” is animated ({paths}): fitting it again would move it in this frame only."
        " Remove those keys or drivers first, or parent the lattice to an animated object instead.",
        name=name,
        paths=", ".join(paths),
    )


def held_points(name: str, modifiers: list[str]) -> str:
    """Modifiers of a lattice object hold its points where they are, also when the object moves."""
    return Sentence(
        "“{name}” has modifiers ({modifiers}) that would not move with it, so its shape would change: switch"
        " them off while fitting it again.",
        name=name,
        modifiers=", ".join(modifiers),
    )


def skewed_by_parent(name: str) -> str:
    """A parent's uneven scale keeps a lattice object from standing straight."""
    return Sentence(
        "The parent of “{name}” skews it, so it cannot be fitted: apply the parent's scale, or clear the parent.",
        name=name,
    )


def resolution_in_edit_mode(name: str) -> str:
    """Blender changes the number of a lattice's points in Object Mode only."""
    return Sentence("“{name}” is in Edit Mode: leave that to change its resolution.", name=name)


def resolution_with_shape_keys(name: str) -> str:
    """Blender does not change the number of points of a lattice that has shape keys."""
    return Sentence("“{name}” has shape keys, so its resolution cannot change: leave Resolution at 0.", name=name)


def resolution_of_splines(name: str) -> str:
    """Only a Bernstein lattice has the same deformation with more points."""
    return Sentence(
        "“{name}” deforms with B-Splines, which would deform otherwise with more points: leave Resolution at 0.",
        name=name,
    )


def resolution_lower(name: str, shape: tuple[int, int, int]) -> str:
    """Fewer points cannot hold the deformation."""
    return Sentence(
        "“{name}” has {shape} points, and fewer would lose some of its deformation: raise Resolution, or leave it at"
        " 0.",
        name=name,
        shape=" × ".join(map(str, shape)),
    )


def nothing_carried(lattice: str, names: str) -> str:
    """The lattice shapes no mesh whose frame could be computed."""
    return Sentence(
        "“{lattice}” carries no mesh that Volume Lattice could compute ({names}): first correct what the sidebar says.",
        lattice=lattice,
        names=names,
    )


def rest_shaped(lattice: str, name: str) -> str:
    """The shape in which jelly comes to rest is the undeformed box, in which this mesh is not embedded."""
    return Sentence(
        "“{lattice}” was already shaped when the rest of “{name}” was set, and jelly comes to rest in the undeformed"
        " box: Clear Rest first.",
        lattice=lattice,
        name=name,
    )


def plays_bake(name: str) -> str:
    """A bake plays instead of the Volume Lattice."""
    return Sentence("“{name}” plays a bake: free the bake first.", name=name)


def simulated(name: str) -> str:
    """A lattice shows a simulation, whose frames are not to be edited one by one."""
    return Sentence("“{name}” shows a simulation: free that first, and simulate again afterwards.", name=name)


def no_pin_group(group: str, lattice: str) -> str:
    """The group of pinned points is missing."""
    return Sentence(
        "The lattice “{lattice}” has no vertex group “{group}”: correct the name under Pinned, or clear it.",
        lattice=lattice,
        group=group,
    )


def no_ground(name: str) -> str:
    """The object named as ground is not in the scene."""
    return Sentence(
        "There is no object “{name}” in the scene: correct the name under Ground Object, or clear it for level ground.",
        name=name,
    )


def no_frames(start: int, end: int) -> str:
    """The range of a simulation has no frame after the first."""
    return Sentence(
        "A simulation from frame {start} to {end} has no frame to move in: let End be greater than Start.",
        start=start,
        end=end,
    )


def in_edit_mode(names: list[str]) -> str:
    """Objects whose points or vertices are being edited."""
    return Sentence("{names} is in Edit Mode: leave it first.", names=listed(names))


def not_shown(name: str) -> str:
    """Blender does not evaluate the object in this view layer."""
    return Sentence("“{name}” is hidden, or in no collection of this view layer: show it first.", name=name)


def ends_before(frame_start: int, frame_end: int) -> str:
    """A range of frames the wrong way round."""
    return Sentence(
        "The last frame ({last}) comes before the first ({first}): correct one of them.",
        first=frame_start,
        last=frame_end,
    )


def absolute_keys(name: str) -> str:
    """The mesh's shape keys are not relative."""
    return Sentence(
        "The shape keys of “{name}” are absolute, played by time: only relative ones can take more.", name=name
    )


def solo_key(name: str) -> str:
    """The object shows the active shape key alone."""
    return Sentence("“{name}” shows one shape key alone: turn Solo off in its shape keys first.", name=name)


BROKEN_EDGES = re.compile(r"(\d+) edges are (open|non-manifold|inconsistently wound)")
"""How the native library counts the edges for which a surface encloses nothing."""
HOLES = re.compile(r"around (one|\d+) holes?: (\d+) edges from vertex (\d+) on")
"""How it counts holes, the edges round the first of them, and names a vertex there."""
NO_CLOSED_ISLAND = re.compile(r"none of \d+ islands encloses")
FLAT_BODY = re.compile(r"body \d+ as bound encloses no volume")
OUT_OF_REACH = re.compile(r"(\S+) cannot be reached, only (\S+) can:")
"""How it names a volume that cannot be reached, and the one that can."""


def not_closed(counts: dict[str, str], holes: Sentence | None) -> str:
    """The mesh encloses nothing; number of edges of each kind in ``BROKEN_EDGES``, and what is known of holes."""
    said = {
        "open": holes
        or Sentence("{count} edges are open: close the holes, or turn on Close Holes.", count=counts.get("open")),
        "non-manifold": Sentence(
            "{count} edges have more than two faces: remove the inner faces.", count=counts.get("non-manifold")
        ),
        "inconsistently wound": Sentence(
            "Along {count} edges the faces look opposite ways: recalculate the normals.",
            count=counts.get("inconsistently wound"),
        ),
    }
    head = Sentence("The mesh is not closed, so it deforms without keeping a volume.")
    return together([head, *(said[kind] for kind in counts)])


def open_holes(count: str, edges: str, place: str) -> Sentence:
    """So many holes, the first of so many edges and at that place in the object's space."""
    if count == "one":
        return Sentence(
            "It has a hole of {edges} edges near {place}: fill it, or turn on Close Holes.", edges=edges, place=place
        )
    return Sentence(
        "It has {count} holes, one of {edges} edges near {place}: fill them, or turn on Close Holes.",
        count=count,
        edges=edges,
        place=place,
    )


def out_of_reach(wanted: str, reachable: str) -> str:
    """A volume that no allowed correction gives, and the nearest one that some does."""
    return Sentence(
        "A volume of {wanted} cannot be reached, only {reachable}: give more axes a share, free stiff points, or make"
        " the lattice larger than the mesh.",
        wanted=wanted,
        reachable=reachable,
    )


def sentence(error: Exception, positions: NDArray[np.floating[Any]] | None = None) -> str:
    """What an error of the native library says, as a sentence of its own; ``positions`` (V, 3) of the mesh tell where
    it has holes."""
    text = str(error)
    if NO_CLOSED_ISLAND.search(text):
        return NO_ISLAND
    if FLAT_BODY.search(text):
        return FLAT_PART
    broken = {kind: count for count, kind in BROKEN_EDGES.findall(text)}
    if broken:
        hole = HOLES.search(text)
        if hole is None or positions is None or int(hole[3]) >= len(positions):
            return not_closed(broken, None)
        return not_closed(broken, _holes(hole, positions))
    reach = OUT_OF_REACH.search(text)
    if reach is not None:
        return out_of_reach(reach[1], reach[2])
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


def _holes(hole: re.Match[str], positions: NDArray[np.floating[Any]]) -> Sentence:
    count, edges, vertex = hole.groups()
    return open_holes(count, edges, "({:.3g}, {:.3g}, {:.3g})".format(*positions[int(vertex)]))
