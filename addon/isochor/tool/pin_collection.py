# SPDX-License-Identifier: GPL-3.0-or-later
"""The collection of a modifier's pins and the empties in it: made, filled, emptied, taken away."""

import bpy
import numpy as np

from ..core import pin_problem, problem
from . import adding, baked, lattices, node_group, pin_record, pins, sockets, stack

MADE_BY_ADD = "isochor_made"
"""Custom property of an empty or a collection that isochor.add_pin made, so that it may be taken away."""
SIZE = 0.05
"""Of an empty when made, as a fraction of the deformed object's largest extent: to be seen and yet not in the way."""


def refuse(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> None:
    """Raises ``Problem`` where pins of this modifier cannot be made or bound."""
    if not obj.is_editable:
        raise problem.Problem(problem.foreign(obj.name))
    if baked.is_playing(obj):
        raise problem.Problem(problem.plays_bake(obj.name))
    if obj.type != "MESH":
        raise problem.Problem(problem.only_meshes(obj.name, obj.type))
    if sockets.PINS not in sockets.identifiers(modifier.node_group):
        raise problem.Problem(pin_problem.older_file(obj.name))
    held = pins.collection(modifier)
    if held is not None and not adding.takes_objects(held):
        raise problem.Problem(pin_problem.foreign_collection(held.name))


def ensure(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, scene: bpy.types.Scene) -> bpy.types.Collection:
    """The collection that the modifier names; where it names none, a new one beside the object, so that whoever
    duplicates the collection of a character duplicates its pins."""
    held = pins.collection(modifier)
    if held is None:
        held = bpy.data.collections.new(f"{obj.name} Pins")
        held[MADE_BY_ADD] = True
        around = [one for one in obj.users_collection if one in scene.collection.children_recursive]
        next(filter(adding.takes_objects, around), scene.collection).children.link(held)
        sockets.write(modifier, sockets.PINS, held)
    return held


def new_empty(
    obj: bpy.types.Object, held: bpy.types.Collection, world: np.ndarray, context: bpy.types.Context
) -> bpy.types.Object:
    """An empty in the collection, at a place in the world."""
    empty = bpy.data.objects.new(f"{obj.name} Pin", None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = SIZE * (max(obj.dimensions) or 1.0)
    empty.show_in_front = True
    empty.location = world
    empty[MADE_BY_ADD] = True
    held.objects.link(empty)
    space = context.space_data
    is_local = space is not None and space.type == "VIEW_3D" and space.local_view is not None
    if is_local and empty.name in context.view_layer.objects:
        empty.local_view_set(space, True)
    return empty


def put_in(held: bpy.types.Collection, obj: bpy.types.Object) -> None:
    """Has the collection hold the object, which stays wherever else it is."""
    if obj.name not in held.all_objects:
        held.objects.link(obj)


def users(obj: bpy.types.Object) -> list[lattices.Pair]:
    """Every deformed object with a modifier that this object is a pin of, in order of name."""
    return [pair for pair in _all() if obj in pins.objects(pair[1])]


def empty(pairs: list[lattices.Pair], chosen: set[int], scene: bpy.types.Scene) -> int:
    """Takes the pins with these session identifiers, or with none given all, out of the collections of the modifiers;
    how many there were."""
    collections = {pins.collection(modifier): modifier for _obj, modifier in pairs}
    count = 0
    for held, modifier in collections.items():
        there = [obj for obj in pins.objects(modifier) if not chosen or obj.session_uid in chosen]
        count += len(there)
        if held is not None and there:
            take_out(held, there, scene)
    return count


def take_out(held: bpy.types.Collection, chosen: list[bpy.types.Object], scene: bpy.types.Scene) -> None:
    """These objects are no longer pins by this collection: an empty that was made for that goes, unless another
    collection has it as a pin too; another object leaves the collection and stays in the scene. A collection that was
    made goes with the last of them."""
    sharing = [pair for pair in _all() if pins.collection(pair[1]) == held]
    marks = {pin_record.mark_of(modifier) for _obj, modifier in sharing}
    for obj in chosen:
        elsewhere = any(pins.collection(modifier) != held for _obj, modifier in users(obj))
        if MADE_BY_ADD in obj and not elsewhere and obj.is_editable:
            bpy.data.objects.remove(obj)
            continue
        for mark in marks if obj.is_editable else ():
            pin_record.forget(obj, mark)
        _unlink(held, obj, scene)
    if MADE_BY_ADD in held and not held.all_objects and not held.children:
        bpy.data.collections.remove(held)
    for _obj, modifier in sharing:
        _tag(modifier)


def take_away(modifier: bpy.types.NodesModifier, scene: bpy.types.Scene) -> None:
    """The modifier goes: so do the empties that were made as its pins, unless another modifier has them too."""
    held = pins.collection(modifier)
    if held is None or MADE_BY_ADD not in held or not adding.takes_objects(held):
        return
    if not any(pins.collection(other) == held for _obj, other in _all() if other != modifier):
        take_out(held, [obj for obj in pins.objects(modifier) if MADE_BY_ADD in obj], scene)


def _unlink(held: bpy.types.Collection, obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Out of the collection and of those below it."""
    for one in (held, *held.children_recursive):
        if obj.name in one.objects and adding.takes_objects(one):
            one.objects.unlink(obj)
    if not obj.users_collection:
        scene.collection.objects.link(obj)


def _tag(modifier: bpy.types.NodesModifier) -> None:
    modifier.id_data.update_tag()
    modifier.node_group = modifier.node_group


def _all() -> list[lattices.Pair]:
    found = stack.users(node_group.all_groups())
    return [(obj, modifier) for obj in found for modifier in stack.ours(obj)]
