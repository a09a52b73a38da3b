# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks over frames as a render sees them, and reads what leaves the Volume Lattice modifiers of some objects.

While walking, the viewport stands in for a render: the modifiers before ours and ours have their render settings, those
that follow are off. Everything is put back at the end, also where the walk is broken off or fails.
"""

from collections.abc import Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.words import Sentence
from . import baked, device, evaluated, rest, results, stack, state


class Moment(NamedTuple):
    """A frame, and the fraction of a frame after it, in [0, 1)."""

    frame: int
    subframe: float = 0.0

    @property
    def words(self) -> str:
        """As people write it, such as 12 or 12.25."""
        return f"{self.frame + self.subframe:.6g}" if self.subframe else str(self.frame)


class Step(NamedTuple):
    """How far a bake is: ``done`` of ``total`` moments, the last of which was ``moment``."""

    done: int
    total: int
    moment: Moment


@dataclass(frozen=True)
class Target:
    """An object and its Volume Lattice modifiers that renders see, in stack order, never none."""

    obj: bpy.types.Object
    ours: tuple[bpy.types.NodesModifier, ...]

    @property
    def last(self) -> bpy.types.NodesModifier:
        """The modifier whose output is meant."""
        return self.ours[-1]

    def problems(self) -> tuple[str, ...]:
        """What was wrong in the frame that was evaluated last, each once."""
        memories = [state.recall(self.obj, modifier) for modifier in self.ours]
        found = [text for memory in memories if memory is not None for text in memory.report.problems]
        return tuple(dict.fromkeys(found))


def moments(frame_start: int, frame_end: int, samples: int = 1) -> list[Moment]:
    """Both ends included, ``samples`` to a frame from each frame but the last."""
    if frame_end < frame_start:
        raise problem.Problem(problem.ends_before(frame_start, frame_end))
    count = (frame_end - frame_start) * samples + 1
    return [Moment(frame_start + index // samples, index % samples / samples) for index in range(count)]


def targets(objects: list[bpy.types.Object]) -> list[Target]:
    """The objects, each once, with what a render sees of ours. Raises Problem, naming the object, where it cannot be
    baked."""
    return [_target(obj) for obj in dict.fromkeys(objects)]


def walk(
    context: bpy.types.Context, chosen: list[Target], when: list[Moment], anchor: Moment | None = None
) -> Generator[Moment]:
    """Shows each moment and yields it once it is evaluated. What is read follows from that moment and the anchor, to
    the last bit: walks that share an anchor, by default the first moment, agree wherever they meet. Use it in
    ``contextlib.closing``, so that everything is put back at once where the loop is left.

    Raises Problem where Blender evaluates one of the objects not at all, as one that is hidden.
    """
    scene, view_layer = context.scene, context.view_layer
    with frame_kept(scene), device.steady(), _as_rendered(chosen, scene, view_layer):
        shown = anchor or when[0]
        _anchor([target.obj for target in chosen], scene, shown)
        for moment in when:
            if moment != shown:
                scene.frame_set(moment.frame, subframe=moment.subframe)
            shown = moment
            for target in chosen:
                _require_evaluated(target.obj, view_layer.depsgraph)
            yield moment


def leaving(target: Target, context: bpy.types.Context) -> NDArray[np.float32]:
    """(V, 3) vertices that leave the last of ours, in object space; only while walking."""
    mesh = target.obj.evaluated_get(context.view_layer.depsgraph).data
    positions = evaluated.attribute(mesh, "position", "vector", 3, np.float32)
    return np.empty((0, 3), np.float32) if positions is None else positions.reshape(-1, 3)


def _target(obj: bpy.types.Object) -> Target:
    name = obj.name
    if not stack.ours(obj):
        raise problem.Problem(
            Sentence("“{name}” has no Volume Lattice: add one first, or name another object.", name=name)
        )
    if obj.type != "MESH":
        raise problem.Problem(problem.only_meshes(name, obj.type))
    if not obj.is_editable:
        raise problem.Problem(problem.linked(name))
    if obj.mode == "EDIT":
        raise problem.Problem(problem.in_edit_mode([name]))
    seen = tuple(modifier for modifier in stack.ours(obj) if baked.seen_by_renders(obj, modifier))
    if not seen:
        raise problem.Problem(
            Sentence("Volume Lattice is switched off for renders on “{name}”: switch it on there first.", name=name)
        )
    return Target(obj, seen)


def _require_evaluated(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    if not obj.evaluated_get(depsgraph).is_evaluated:
        raise problem.Problem(Sentence("“{name}” is hidden with its collection: show that first.", name=obj.name))


def _anchor(objects: list[bpy.types.Object], scene: bpy.types.Scene, moment: Moment) -> None:
    state.forget(objects)
    scene.frame_set(moment.frame, subframe=moment.subframe)
    state.anchor(objects)


@contextmanager
def frame_kept(scene: bpy.types.Scene) -> Iterator[None]:
    """Shows the frame and its fraction again that the scene stood at."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        scene.frame_set(frame, subframe=subframe)


@contextmanager
def _as_rendered(chosen: list[Target], scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Iterator[None]:
    rest.measure_missing(view_layer)
    with ExitStack() as undo:
        if scene.render.use_simplify:
            _set(scene.render, "simplify_subdivision", scene.render.simplify_subdivision_render, undo)
        for target in chosen:
            _unhide(target.obj, view_layer, undo)
            _set_for_walk(target, undo)
        undo.callback(state.forget, [target.obj for target in chosen])
        yield


def _unhide(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer, undo: ExitStack) -> None:
    """Renders see what the viewport alone hides."""
    _set(obj, "hide_viewport", False, undo)
    if obj.hide_get(view_layer=view_layer):
        obj.hide_set(False, view_layer=view_layer)
        undo.callback(obj.hide_set, True, view_layer=view_layer)


def _set_for_walk(target: Target, undo: ExitStack) -> None:
    for modifier in target.ours:
        if stack.differing_before(target.obj, modifier):
            _swap_rest(modifier)
            undo.callback(_swap_rest, modifier)
    for block in baked.keys(target.obj):
        _set(block, "mute", True, undo)
    place = list(target.obj.modifiers).index(target.last)
    for index, modifier in enumerate(target.obj.modifiers):
        shown = index <= place and baked.seen_by_renders(target.obj, modifier)
        _set(modifier, "show_viewport", shown, undo)
        if index <= place and hasattr(modifier, "render_levels"):
            _set(modifier, "levels", modifier.render_levels, undo)


def _set(owner: bpy.types.bpy_struct, name: str, value: object, undo: ExitStack) -> None:
    before = getattr(owner, name)
    if before != value:
        setattr(owner, name, value)
        undo.callback(setattr, owner, name, before)


def _swap_rest(modifier: bpy.types.NodesModifier) -> None:
    """Exchanges what the results of viewport and render know of the rest volume."""
    shown, rendered = (results.of(modifier, mode) for mode in ("VIEWPORT", "RENDER"))
    if shown is None or rendered is None:
        return
    for key in results.REST_KEYS:
        one, other = shown.get(key), rendered.get(key)
        for owner, value in ((shown, other), (rendered, one)):
            if value is not None:
                owner[key] = value
            elif key in owner:
                del owner[key]
