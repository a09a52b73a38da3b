# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on keeps in this session; one lock serialises the viewport's and the render's threads."""

import threading
from collections import Counter
from collections.abc import Callable

import bpy

from . import frame_memory, node_group, results, stack
from .job import Memory
from .update import update_object

EDITED = (bpy.types.Mesh, bpy.types.Lattice, bpy.types.Curve, bpy.types.Curves, bpy.types.PointCloud)
"""Data whose edits are counted; a text is a kind of curve."""

_lock = threading.RLock()
_memories: dict[tuple[int, int, str], Memory] = {}
_printed: set[str] = set()
_edits: Counter[int] = Counter()
"""Edits seen of each mesh and lattice, by its session identifier."""


def clear() -> None:
    """Forgets everything, as after loading a file or an undo, where Blender's data is another."""
    with _lock:
        _memories.clear()
        frame_memory.clear()
        _edits.clear()


def start_file() -> None:
    """Forgets everything, and what was printed: in another file it is to be said again."""
    with _lock:
        clear()
        _printed.clear()


def forget(objects: list[bpy.types.Object]) -> None:
    """Has these objects computed anew next time, as if no frame had come before."""
    with _lock:
        for key in _keys(objects):
            frame_memory.forget(_memories.pop(key).solver)


def change_memory(change: Callable[[], None]) -> None:
    """Calls one of ``frame_memory``'s functions while nothing computes."""
    with _lock:
        change()


def anchor(objects: list[bpy.types.Object]) -> None:
    """Has every frame of these objects follow, to the last bit, from itself and the frame that was computed just now,
    which must have been the first since ``forget``; until the next ``forget``."""
    with _lock:
        for key in _keys(objects):
            memory = _memories[key]
            memory.anchor, memory.anchored = memory.solver.bound_transform, True


def recall(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str = "VIEWPORT") -> Memory | None:
    """What is known of a modifier since it was last computed; its report is what the sidebar shows."""
    return _memories.get((obj.session_uid, modifier.persistent_uid, mode))


def refresh(objects: list[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> None:
    """Computes these objects' modifiers from what ``depsgraph`` evaluated and writes their result meshes."""
    with _lock:
        _edits.update(edited_data(depsgraph))
        if not objects:
            return
        results.ensure_own()
        for obj in objects:
            if obj.mode != "OBJECT":
                # Sculpting and its like change the mesh without Blender reporting an edit of it.
                _edits[obj.data.session_uid] += 1
            for memory in update_object(obj, depsgraph, _edits, _memories):
                _print_once(obj, memory.report.problems)


def edited_data(depsgraph: bpy.types.Depsgraph) -> set[int]:
    """Session identifiers of the lattices, meshes and other data that were edited since it evaluated last."""
    return {
        update.id.original.session_uid
        for update in depsgraph.updates
        if update.is_updated_geometry and isinstance(update.id, EDITED)
    }


def updated_users(depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object]:
    """Objects with our modifier whose geometry or place has been evaluated anew."""
    if not node_group.all_groups():
        return []
    found = []
    for update in depsgraph.updates:
        if not isinstance(update.id, bpy.types.Object) or not (
            update.is_updated_geometry or update.is_updated_transform
        ):
            continue
        original = update.id.original
        if original.type in stack.DEFORMED and any(map(stack.is_ours, original.modifiers)):
            found.append(original)
    return found


def _keys(objects: list[bpy.types.Object]) -> list[tuple[int, int, str]]:
    uids = {obj.session_uid for obj in objects}
    return [key for key in _memories if key[0] in uids]


def _print_once(obj: bpy.types.Object, problems: tuple[str, ...]) -> None:
    for text in problems:
        line = f"Isochor: {obj.name}: {text}"
        if line not in _printed:
            _printed.add(line)
            print(line, flush=True)
