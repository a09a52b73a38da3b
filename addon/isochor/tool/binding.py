# SPDX-License-Identifier: GPL-3.0-or-later
"""Setting and clearing a modifier's rest: the lattice as it stands now."""

import bpy

from ..core import grid, problem
from ..core.bound import BoundShape
from . import baked, bound, chain, evaluated, own_points, rest, results, sockets, state

Pair = tuple[bpy.types.Object, bpy.types.NodesModifier]


def shape_now(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> BoundShape:
    """The modifier's lattice as it stands, seen from the object; raises a Problem where there is none to bind with."""
    if baked.is_playing(obj):
        raise problem.Problem(problem.plays_bake(obj.name))
    original = sockets.read(modifier, sockets.LATTICE)
    if original is None:
        raise problem.Problem(problem.NO_LATTICE)
    if original.type != "LATTICE":
        raise problem.Problem(problem.not_a_lattice(original.name, original.type))
    shown, lattice = obj.evaluated_get(depsgraph), original.evaluated_get(depsgraph)
    for one in (shown, lattice):
        if not one.is_evaluated:
            raise problem.Problem(problem.hidden(one.name))
    memory = state.recall(obj, modifier)
    box = evaluated.UNIT_BOX if memory is None else memory.lattice_boxes.get(original.session_uid, evaluated.UNIT_BOX)
    points = evaluated.lattice_points(lattice, box)
    matrices = evaluated.matrix(shown), evaluated.matrix(lattice)
    transform = grid.relative_transform(*matrices, (obj.name, original.name))
    shape = BoundShape(original.name, points.shape, points.low, points.high, transform, points.deformed)
    shape.refuse_flat()
    return shape


def bind(pairs: list[Pair], shapes: list[BoundShape], view_layer: bpy.types.ViewLayer) -> None:
    """Binds each modifier with its shape, and measures its rest volume anew, with that of all in its chain."""
    results.ensure_own()
    measured = chain.whole_of_all(pairs)
    for (obj, modifier), shape in zip(pairs, shapes, strict=True):
        for result in _both(modifier):
            bound.keep(result, shape, own_points.count(obj))
    for obj, modifier in measured:
        for result in _both(modifier):
            results.forget_rest(result)
        obj.update_tag(refresh={"DATA"})
    view_layer.update()
    for obj, modifier in measured:
        rest.measure_for_render(obj, modifier, view_layer)


def release(pairs: list[Pair], view_layer: bpy.types.ViewLayer) -> None:
    """Unbinds the modifiers: the lattice's present place embeds again. The rest volume stays."""
    results.ensure_own()
    for obj, modifier in pairs:
        for result in _both(modifier):
            bound.forget(result)
        obj.update_tag(refresh={"DATA"})
    view_layer.update()


def _both(modifier: bpy.types.NodesModifier) -> list[bpy.types.Object]:
    found = [results.of(modifier, mode) for mode in results.INPUT_OF_MODE]
    return [result for result in found if result is not None]
