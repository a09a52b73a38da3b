# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts Volume Lattices in the place of Blender's own Lattice modifiers, which deform the same."""

from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.words import Sentence, named, together
from . import adding, animation_paths, drivers, own_points, removing, rest, results, sockets, stack, state

Pair = tuple[bpy.types.Object, bpy.types.LatticeModifier]

INPUTS = {"strength": "Strength", "vertex_group": "Vertex Group", "invert_vertex_group": "Invert"}
"""Properties of Blender's modifier, and the inputs of ours that stand for them."""
SWITCHES = ("show_viewport", "show_render", "show_in_editmode", "show_expanded", "use_pin_to_last")
REPLACED = ".Replaced"
"""What the old modifier's name ends in for as long as both are there."""
SAME = 1e-5
"""Largest difference of the two shapes, as a fraction of the object's size, that nobody is told of."""


@dataclass(frozen=True)
class Change:
    """One modifier of Blender's that one of ours has replaced, switched off and renamed; and how to go back."""

    obj: bpy.types.Object
    native: bpy.types.LatticeModifier
    ours: bpy.types.NodesModifier
    name: str
    switches: dict[str, bool]
    before: NDArray[np.float64] = field(repr=False)


def native(obj: bpy.types.Object) -> list[bpy.types.LatticeModifier]:
    """Blender's own Lattice modifiers of the object, in stack order."""
    return [modifier for modifier in obj.modifiers if modifier.type == "LATTICE"]


def users_of(lattice: bpy.types.Object) -> list[bpy.types.Object]:
    """Objects that Blender's own modifier deforms by this lattice, in order of name."""
    return [obj for obj in bpy.data.objects if any(modifier.object == lattice for modifier in native(obj))]


def refuse(pairs: list[Pair]) -> None:
    """Raises Problem where one of them cannot be replaced without a visible change."""
    for obj, modifier in pairs:
        _refuse_object(obj, modifier)
        _refuse_modifier(obj, modifier)
    chosen = [modifier for _, modifier in pairs]
    for obj in dict.fromkeys(obj for obj, _ in pairs):
        between = _between(obj, chosen)
        if between:
            raise problem.Problem(named(obj.name, problem.between(between)))


def _refuse_object(obj: bpy.types.Object, modifier: bpy.types.LatticeModifier) -> None:
    if obj.type != "MESH":
        raise problem.Problem(Sentence("“{name}” is no mesh: only those of meshes can be converted.", name=obj.name))
    if not obj.is_editable:
        raise problem.Problem(problem.foreign(obj.name))
    if obj.override_library is not None and modifier.is_override_data:
        raise problem.Problem(problem.modifier_of_library(obj.name, modifier.name))
    if obj.mode != "OBJECT":
        raise problem.Problem(Sentence("“{name}” is in another mode: go to Object Mode first.", name=obj.name))


def _refuse_modifier(obj: bpy.types.Object, modifier: bpy.types.LatticeModifier) -> None:
    if modifier.object is None:
        raise problem.Problem(
            Sentence(
                "“{modifier}” of “{name}” has no lattice: pick one there, or remove it.",
                modifier=modifier.name,
                name=obj.name,
            )
        )
    path = f"{animation_paths.of_modifier(modifier)}.strength"
    keyed = animation_paths.curves_at(obj, path)
    strengths = [modifier.strength, *(value for curve in keyed for value in _values(curve))]
    if min(strengths) < 0.0 or max(strengths) > 1.0:
        raise problem.Problem(
            Sentence(
                "The strength of “{modifier}” of “{name}” is, or goes, below 0 or above 1, where a Volume Lattice does"
                " not follow: keep it between.",
                modifier=modifier.name,
                name=obj.name,
            )
        )
    paths = [f"{animation_paths.of_modifier(modifier)}.{name}" for name in INPUTS]
    if animation_paths.readers(obj, paths):
        raise problem.Problem(
            Sentence(
                "Drivers read the strength of “{modifier}” of “{name}”, and Blender does not tell drivers when an input"
                " of a Volume Lattice changes: have them read what drives it instead.",
                modifier=modifier.name,
                name=obj.name,
            )
        )
    shared = animation_paths.not_alone(obj, paths)
    if shared:
        raise problem.Problem(
            Sentence(
                "The action “{action}” of “{name}” is another file's, or animates others too: make it single-user"
                " first.",
                action=shared,
                name=obj.name,
            )
        )


def _between(obj: bpy.types.Object, chosen: list[bpy.types.LatticeModifier]) -> list[str]:
    """Names of modifiers that would stand between two of ours."""
    modifiers = list(obj.modifiers)
    ours = [place for place, one in enumerate(modifiers) if one in chosen or stack.is_ours(one)]
    found = modifiers[ours[0] : ours[-1]] if ours else []
    return [other.name for other in found if other not in chosen and not stack.is_ours(other)]


def _values(curve: bpy.types.FCurve) -> list[float]:
    """What the curve gives in the frames from its first key to its last."""
    first, last = (int(frame) for frame in curve.range())
    return [float(curve.evaluate(frame)) for frame in range(first, last + 2)]


def convert(pairs: list[Pair], preserve: bool, context: bpy.types.Context) -> list[str]:
    """Replaces each; returns warnings in plain words. Raises Problem, with nothing changed, where ours does not deform
    the object at all."""
    shown = {obj.name: _shown(obj, context) for obj, _ in pairs}
    changes = [_replace(obj, modifier, shown[obj.name]) for obj, modifier in pairs]
    results.ensure_own()
    context.view_layer.update()
    failed = [change for change in changes if change.switches["show_viewport"] and not _deforms(change)]
    if failed:
        said = [named(change.obj.name, together(_problems(change))) for change in failed]
        for change in reversed(changes):
            _take_back(change)
        context.view_layer.update()
        raise problem.Problem(together(said))
    for change in changes:
        _finish(change, preserve)
    context.view_layer.update()
    for change in changes:
        rest.measure_for_render(change.obj, change.ours, context.view_layer)
    return _warnings(changes, preserve, context)


def _replace(obj: bpy.types.Object, modifier: bpy.types.LatticeModifier, before: NDArray[np.float64]) -> Change:
    name = modifier.name
    ours = adding.new_modifier(obj, modifier.object, "BLENDER")
    stack.move_behind(ours, modifier)
    switches = {switch: bool(getattr(modifier, switch)) for switch in SWITCHES}
    for switch, value in switches.items():
        setattr(ours, switch, value)
    for native_name, input_name in INPUTS.items():
        sockets.write(ours, input_name, getattr(modifier, native_name))
    sockets.write(ours, "Outside", "Extend")
    sockets.write(ours, "Preserve", 0.0)
    # Curves and drivers go with a modifier that is renamed: to the new name, and from there to ours.
    modifier.name = name + REPLACED
    ours.name = name
    animation_paths.rename(obj, _paths(modifier, ours))
    modifier.show_viewport = modifier.show_render = False
    return Change(obj, modifier, ours, name, switches, before)


def _paths(modifier: bpy.types.LatticeModifier, ours: bpy.types.NodesModifier) -> dict[str, str]:
    """Where curves and drivers led, and where they are to lead."""
    before, after = (animation_paths.of_modifier(one) for one in (modifier, ours))
    switches = {f"{before}.{name}": f"{after}.{name}" for name in SWITCHES}
    return switches | {f"{before}.{name}": drivers.data_path(ours, given) for name, given in INPUTS.items()}


def _take_back(change: Change) -> None:
    animation_paths.rename(change.obj, {new: old for old, new in _paths(change.native, change.ours).items()})
    # Blender numbers a name that is taken.
    change.ours.name = change.native.name
    change.native.name = change.name
    for switch, value in change.switches.items():
        setattr(change.native, switch, value)
    removing.remove(change.obj, change.ours)


def _finish(change: Change, preserve: bool) -> None:
    was_active = change.obj.modifiers.active == change.native
    change.obj.modifiers.remove(change.native)
    if was_active:
        change.obj.modifiers.active = change.ours
    if preserve:
        sockets.write(change.ours, "Preserve", 1.0)


def _deforms(change: Change) -> bool:
    memory = state.recall(change.obj, change.ours)
    return memory is not None and memory.written is not None and memory.written.vertices is not None


def _problems(change: Change) -> tuple[str, ...]:
    memory = state.recall(change.obj, change.ours)
    problems = () if memory is None else memory.report.problems
    return problems or (problem.not_shown(change.obj.name),)


def _warnings(changes: list[Change], preserve: bool, context: bpy.types.Context) -> list[str]:
    found: list[str] = [named(change.obj.name, text) for change in changes for text in _reported(change)]
    if preserve:
        return found
    for change in {change.obj.name: change for change in changes}.values():
        after = _shown(change.obj, context)
        if len(after) == len(change.before) and len(after):
            size = float(np.ptp(change.before, axis=0).max()) or 1.0
            apart = float(np.abs(after - change.before).max()) / size
            if apart > SAME:
                found.append(
                    Sentence(
                        "“{name}” is {percent} % of its size off what it was: undo, and keep Blender's own modifier",
                        name=change.obj.name,
                        percent=f"{100.0 * apart:.2g}",
                    )
                )
    return found


def _reported(change: Change) -> tuple[str, ...]:
    memory = state.recall(change.obj, change.ours)
    return () if memory is None else memory.report.problems


def _shown(obj: bpy.types.Object, context: bpy.types.Context) -> NDArray[np.float64]:
    """(V, 3) vertices that the viewport shows."""
    return own_points.shown(obj.evaluated_get(context.evaluated_depsgraph_get()))
