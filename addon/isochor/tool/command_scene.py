# SPDX-License-Identifier: GPL-3.0-or-later
"""What every command does first: opens the file, finds the objects; and the lines of progress that farms read."""

import hashlib
from pathlib import Path

import bpy

from ..core.problem import Problem
from . import baked, frames, node_group, stack


def open_file(path: Path) -> None:
    """Opens a .blend; scripts in it run only where Blender was told so, as by --enable-autoexec. Raises Problem where
    that cannot be done."""
    if not path.is_file():
        raise Problem(f"“{path}” is not there: name a .blend file.")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.absolute()), load_ui=False)
    except RuntimeError as error:
        raise Problem(f"“{path}” cannot be opened: {str(error).strip()}") from error


def fingerprint(path: Path) -> str:
    """SHA-256 of the open file and of the libraries that it links, hexadecimal."""
    found = [_digest(path)]
    for library in sorted(bpy.data.libraries, key=lambda library: library.filepath):
        place = Path(bpy.path.abspath(library.filepath, library=library.parent))
        found.append(_digest(place) if place.is_file() else "missing")
    return found[0] if len(found) == 1 else hashlib.sha256("\n".join(found).encode()).hexdigest()


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def chosen_targets(names: list[str]) -> list[frames.Target]:
    """The objects of these names; without names, all that renders see and that have a Volume Lattice which they see."""
    if names:
        return frames.targets([_named(name) for name in dict.fromkeys(names)])
    shown = set(bpy.context.view_layer.objects)
    users = [obj for obj in stack.users(node_group.all_groups()) if obj in shown and not obj.hide_render]
    found = [obj for obj in users if any(baked.seen_by_renders(obj, modifier) for modifier in stack.ours(obj))]
    if not found:
        raise Problem("No object of the scene has a Volume Lattice that renders see: there is nothing to do.")
    return frames.targets(found)


def tell(step: frames.Step, what: str) -> None:
    """Prints the lines of progress: one for people and Deadline, one as OpenJD wants it."""
    percent = 100.0 * step.done / max(step.total, 1)
    print(f"Fra:{step.moment.words} | {what} | Progress: {int(percent)}%", flush=True)
    print(f"openjd_progress: {percent:.1f}", flush=True)


def tell_done() -> None:
    """Prints that nothing is left to do."""
    print("Progress: 100%\nopenjd_progress: 100.0", flush=True)


def _named(name: str) -> bpy.types.Object:
    all_objects = bpy.context.scene.objects
    # A linked object and its override may have the same name.
    found = next((obj for obj in all_objects if obj.name == name and obj.is_editable), all_objects.get(name))
    if found is None:
        elsewhere = " in this scene" if name in bpy.data.objects else ""
        raise Problem(f"There is no object “{name}”{elsewhere}: correct the name, in capitals and small letters too.")
    if found.type != "MESH":
        raise Problem(f"“{name}” is not a mesh but of type {found.type.lower()}: name the mesh that is deformed.")
    return found
