# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators that put drivers have in common: which modifiers, which target, and what they refuse."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy

from ..core import problem
from ..core.kinds import Kind
from ..core.words import Sentence, listed, sentence
from ..tool import drivers, lattice_frame, sockets, words
from .choosing import active_object, chosen_modifiers

Pairs = list[tuple[bpy.types.Object, bpy.types.NodesModifier]]

NOTHING_CHOSEN = "Select a mesh with a Volume Lattice, or its lattice"


class Refused(problem.Problem):
    """Why an operator does nothing, in plain words."""


class Driving:
    """For operators that put drivers on the inputs of the chosen modifiers, in ``put``."""

    bl_options = {"REGISTER", "UNDO"}
    asks_for: tuple[str, tuple[str, ...]] = ("", ())
    """The property that names the target, empty where none is needed; the kinds of object that it can be, or any."""
    moves = False
    """Whether the driver makes sense only where the lattice moves along with the object."""
    if TYPE_CHECKING:
        report: Callable[[set[str], str], None]
        poll_message_set: Callable[[str], None]

    replace: bpy.props.BoolProperty(
        name="Replace",
        description="Put it in the place of a driver that is already there and not the add-on's own",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set(NOTHING_CHOSEN)
        return False

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Asks for the target where the selection does not tell it."""
        name, kinds = self.asks_for
        told = not name or getattr(self, name) or len(beside(context, chosen_modifiers(context), kinds)) == 1
        if told or bpy.app.background:
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self, width=380)

    def execute(self, context: bpy.types.Context) -> set[str]:
        pairs = chosen_modifiers(context)
        try:
            self.put(context, pairs)
        except problem.Problem as reason:
            self.report({"ERROR"}, words.reported(reason.sentence))
            return {"CANCELLED"}
        for obj, modifier in pairs:
            lattice = sockets.read(modifier, sockets.LATTICE)
            if self.moves and not lattice_frame.goes_along(lattice, obj):
                self.report({"WARNING"}, words.reported(problem.left_behind(lattice.name, obj.name)))
        return {"FINISHED"}

    def put(self, context: bpy.types.Context, pairs: Pairs) -> None:
        """Puts the drivers; raises Refused before anything is changed."""
        raise NotImplementedError


def refuse_taken(pairs: Pairs, names: tuple[str, ...], replace: bool) -> None:
    """Raises Refused where an object belongs to another file, or an input is absent, keyed, or driven by others."""
    for obj, modifier in pairs:
        if not obj.is_editable:
            raise Refused(problem.foreign(listed([obj.name])))
        for name in names:
            refuse_input(obj, modifier, name, replace)


def refuse_input(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, name: str, replace: bool) -> None:
    """Raises Refused where this one input cannot be driven."""
    if name not in sockets.identifiers(modifier.node_group):
        raise Refused(
            Sentence(
                "The Volume Lattice of “{name}” comes from an older file and has no input {input}: open and save"
                " that file",
                name=obj.name,
                input=name,
            )
        )
    path = drivers.data_path(modifier, name)
    if drivers.keys_of(obj, path) is not None:
        raise Refused(
            Sentence(
                "{input} of “{name}” has keys, which a driver would hide: delete them first", input=name, name=obj.name
            )
        )
    curve = drivers.of(obj, path)
    if curve is not None and not replace and not drivers.is_own(curve):
        raise Refused(
            Sentence(
                "{input} of “{name}” has a driver of yours already: delete it, or turn on Replace",
                input=name,
                name=obj.name,
            )
        )


def no_lattice(name: str) -> str:
    """The modifier of the object of this name has no lattice, or one that is flat."""
    return Sentence(
        "The Volume Lattice of “{name}” has no lattice with a size: pick one in its Lattice input", name=name
    )


def target(
    context: bpy.types.Context, name: str, pairs: Pairs, what: str, kinds: tuple[str, ...] = ()
) -> bpy.types.Object:
    """The object called ``name``, or without a name the one that is selected beside the meshes and lattices of
    ``pairs``, of one of ``kinds`` where any are named. ``what``: the name of the operator's input for it."""
    if name:
        return named_target(name, what, kinds)
    found = beside(context, pairs, kinds)
    if len(found) == 1:
        return found[0]
    raise Refused(not_one(what, kinds, [obj.name for obj in found]))


def not_one(what: str, kinds: tuple[str, ...], found: list[str]) -> Sentence:
    """Not one object that could be meant was selected, but none or these."""
    values = {"what": sentence(what), "kind": Kind(kinds[0]) if kinds else "", "names": ", ".join(found)}
    if kinds and found:
        return Sentence("{what}: select one object of the kind {kind} as well, or name it (found {names})", **values)
    if kinds:
        return Sentence("{what}: select an object of the kind {kind} as well, or name it (found none)", **values)
    if found:
        return Sentence("{what}: select one other object as well, or name it (found {names})", **values)
    return Sentence("{what}: select one other object as well, or name it (found none)", **values)


def named_target(name: str, what: str, kinds: tuple[str, ...]) -> bpy.types.Object:
    """The object of this name, refused where there is none of such a kind."""
    obj = bpy.data.objects.get(name)
    if obj is None:
        raise Refused(
            Sentence(
                "{what}: there is no object “{name}”; correct the name, or clear it and select the object",
                what=sentence(what),
                name=name,
            )
        )
    if kinds and obj.type not in kinds:
        raise Refused(
            Sentence(
                "{what}: “{name}” is of the kind {kind}; it must be {wanted}",
                what=sentence(what),
                name=name,
                kind=Kind(obj.type),
                wanted=Kind(kinds[0]),
            )
        )
    return obj


def beside(context: bpy.types.Context, pairs: Pairs, kinds: tuple[str, ...]) -> list[bpy.types.Object]:
    """The active and selected objects that are neither the meshes of ``pairs`` nor their lattices."""
    ours = {obj for obj, _modifier in pairs} | {sockets.read(modifier, sockets.LATTICE) for _obj, modifier in pairs}
    chosen = list(context.view_layer.objects.selected)
    active = active_object(context)
    if active is not None and active not in chosen:
        chosen.append(active)
    return [obj for obj in chosen if obj not in ours and (not kinds or obj.type in kinds)]


def search_objects(_operator: object, _context: bpy.types.Context, typed: str) -> list[str]:
    """Names of objects that hold what was typed."""
    return [obj.name for obj in bpy.data.objects if typed.lower() in obj.name.lower()]
