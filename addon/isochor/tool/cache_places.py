# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the point caches of objects lie."""

from pathlib import Path

import bpy

from ..core import problem
from ..core.file_names import unique_names
from ..core.point_cache import SUFFIXES, Format
from ..core.words import Sentence
from . import node_group, stack

FOLDER = "isochor_cache"
"""Beside the .blend, where no other folder is given."""


def default_folder() -> str:
    """Relative to the .blend where that is saved, else empty."""
    return f"//{FOLDER}/{Path(bpy.data.filepath).stem}/" if bpy.data.filepath else ""


def absolute(place: str) -> Path:
    """A path as Blender's fields hold it. Raises Problem where it is relative to a file that is not saved."""
    if place.startswith("//") and not bpy.data.filepath:
        raise problem.Problem(
            Sentence("“{place}” means beside the .blend, which is not saved yet: save it first.", place=place)
        )
    return Path(bpy.path.abspath(place)).absolute()


def relative(path: Path) -> str:
    """As Blender's fields should hold it: relative to the .blend where that is saved and on the same drive."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:
        return str(path)


def file_names(objects: list[bpy.types.Object]) -> list[str]:
    """For each object a name without suffix that no other object of the file gets, whichever are asked for."""
    users = list(dict.fromkeys([*stack.users(node_group.all_groups()), *objects]))
    names = unique_names([_full_name(obj) for obj in users])
    found = dict(zip(users, names, strict=True))
    return [found[obj] for obj in objects]


def in_folder(objects: list[bpy.types.Object], folder: Path, kind: Format) -> list[Path]:
    """A file in the folder for each object."""
    return [folder / (name + SUFFIXES[kind]) for name in file_names(objects)]


def _full_name(obj: bpy.types.Object) -> str:
    """The name, and with objects of other files theirs, since several may have the same."""
    return obj.name if obj.library is None else f"{obj.name} {obj.library.name}"
