# SPDX-License-Identifier: GPL-3.0-or-later
"""The result meshes: points only, in no collection, held by the modifier that takes its positions from them.

Two for each modifier, because viewport and render may see different meshes at the same time. An object in Blender's
sense carries each, since an input can name an object only.
"""

import json
from functools import lru_cache

import bpy

from ..core.request import Vertices
from ..core.volume import enclosed, has_changed
from . import bound, evaluated, node_group, own_points, sockets, stack

REST_VOLUME = "isochor_rest_volume"
"""Custom property of a result object: volume that entered when the modifier was added or bound, in object space."""
REST_COUNT = "isochor_rest_count"
"""Custom property of a result object: number of the object's own points at that time."""
REST_OWN_VOLUME = "isochor_rest_own_volume"
"""Custom property of a result object: volume of the object's own mesh at that time, which tells of edits since."""
REST_PARTS = "isochor_rest_parts"
"""Custom property of a result object: volumes of the bodies when they were first asked for, as JSON, by the stamp of
``core.bodies.Bodies``."""
REST_KEYS = (REST_VOLUME, REST_COUNT, REST_OWN_VOLUME, REST_PARTS)

INPUT_OF_MODE = {"VIEWPORT": sockets.VIEWPORT_RESULT, "RENDER": sockets.RENDER_RESULT}


def of(modifier: bpy.types.NodesModifier, mode: str) -> bpy.types.Object | None:
    """The result object of an original (not evaluated) modifier in this mode.

    Never the deformed object itself, into whose mesh nothing may be written: Blender can mix up the two in an undo, as
    the module ``mixed_up`` tells.
    """
    result: bpy.types.Object | None = sockets.read(modifier, INPUT_OF_MODE[mode])
    return None if result == modifier.id_data else result


def ensure_own() -> None:
    """Gives every modifier result objects and a slot of its own; a copied object or modifier shares those it came
    from, and the first in order of name keeps them. A library override gets local ones; what is linked without
    override cannot be given any."""
    taken: set[int] = set()
    for obj in stack.users(node_group.all_groups()):
        if not obj.is_editable:
            continue
        for modifier in stack.ours(obj):
            _ensure_slot(modifier)
            for mode in INPUT_OF_MODE:
                taken.add(_ensure_result(obj, modifier, mode, taken))


def write(result: bpy.types.Object, positions: Vertices | None) -> None:
    """Makes the result's points these (V, 3) positions; with None no points, which shows the undeformed mesh."""
    mesh = result.data
    count = 0 if positions is None else len(positions)
    if len(mesh.vertices) != count:
        mesh.clear_geometry()
        mesh.vertices.add(count)
        mesh.update_tag()
    if positions is not None and count:
        mesh.attributes["position"].data.foreach_set("vector", positions.reshape(-1))


def keep_rest(result: bpy.types.Object, volume: float, obj: bpy.types.Object) -> None:
    """Notes the volume that entered, in the space of ``obj``, the deformed object."""
    result[REST_VOLUME] = volume
    _note_own(result, obj)


def keep_parts(result: bpy.types.Object, stamp: str, parts: tuple[float, ...], obj: bpy.types.Object) -> None:
    """Notes the volumes of the bodies, in place of those of other regions of as many vertices."""
    like = stamp.rpartition(":")[0]
    others = {key: kept for key, kept in _parts(result.get(REST_PARTS, "{}")).items() if key.rpartition(":")[0] != like}
    result[REST_PARTS] = json.dumps({**others, stamp: parts})
    if REST_COUNT not in result:
        _note_own(result, obj)


def kept_parts(result: bpy.types.Object | None, stamp: str) -> tuple[float, ...] | None:
    """The volumes of the bodies with this stamp, or None where they are not known."""
    return None if result is None else _parts(result.get(REST_PARTS, "{}")).get(stamp)


def kinds_of_parts(result: bpy.types.Object) -> set[str]:
    """The kinds of bodies whose volumes are known."""
    return {stamp.partition(":")[0] for stamp in _parts(result.get(REST_PARTS, "{}"))}


def copy_rest(source: bpy.types.Object, result: bpy.types.Object) -> None:
    """Gives a result object all that another one knows of the rest volume."""
    for key in REST_KEYS:
        if key in source:
            result[key] = source[key]


@lru_cache(maxsize=64)
def _parts(text: str) -> dict[str, tuple[float, ...]]:
    return {stamp: tuple(volumes) for stamp, volumes in json.loads(text).items()}


def _note_own(result: bpy.types.Object, obj: bpy.types.Object) -> None:
    result[REST_COUNT] = own_points.count(obj)
    if obj.type == "MESH":
        result[REST_OWN_VOLUME] = enclosed(*evaluated.own_shape(obj.data))


def is_edited(result: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether the own mesh of ``obj`` has another volume than when the rest volume was kept; of a text or a curve,
    whether it has another number of letters or points."""
    if obj.type != "MESH":
        return bool(result[REST_COUNT] != own_points.count(obj))
    return has_changed(result[REST_OWN_VOLUME], *evaluated.own_shape(obj.data))


def forget_rest(result: bpy.types.Object) -> None:
    """The next volume that enters becomes the rest volume, as after copying the modifier to another mesh."""
    for key in REST_KEYS:
        if key in result:
            del result[key]


def remove(modifier: bpy.types.NodesModifier) -> None:
    """Takes a modifier's result objects and meshes out of the file."""
    for mode in INPUT_OF_MODE:
        result = of(modifier, mode)
        if result is not None:
            mesh = result.data
            bpy.data.objects.remove(result)
            bpy.data.meshes.remove(mesh)


def _ensure_slot(modifier: bpy.types.NodesModifier) -> None:
    slot = str(modifier.persistent_uid)
    if sockets.read(modifier, sockets.SLOT) != slot:
        sockets.write(modifier, sockets.SLOT, slot)


def _ensure_result(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str, taken: set[int]) -> int:
    """The session identifier of the modifier's own result object, made or cloned where it has none."""
    result = of(modifier, mode)
    if result is None or result.session_uid in taken or not result.is_editable:
        result = _new(f".{node_group.NAME} {obj.name} {mode.lower()}", result)
        if result.get(REST_COUNT) != own_points.count(obj):
            forget_rest(result)
        bound.forget_of_other(result, own_points.count(obj))
        sockets.write(modifier, INPUT_OF_MODE[mode], result)
    return result.session_uid


def _new(name: str, like: bpy.types.Object | None) -> bpy.types.Object:
    if like is None:
        return bpy.data.objects.new(name, bpy.data.meshes.new(name))
    result, mesh = like.copy(), like.data.copy()
    result.name = mesh.name = name
    result.data = mesh
    return result
