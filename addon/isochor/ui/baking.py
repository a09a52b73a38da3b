# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators isochor.bake and isochor.free_bake."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import bpy

from ..core import problem
from ..core.point_cache import SUFFIXES
from ..core.words import Sentence
from ..tool import bake_file, bake_keys, bake_lattice, baked, cache_places, frames, words
from .choosing import chosen_modifiers, chosen_objects
from .frames import FrameRange
from .stepping import Bake, Stepping

Pairs = list[tuple[bpy.types.Object, bpy.types.NodesModifier]]
"""An object and the modifier of it that is meant."""


class Format(NamedTuple):
    """A way to bake: its name in scripts, its name and description for people, and what begins it."""

    identifier: str
    label: str
    description: str
    begin: Callable[["ISOCHOR_OT_bake", bpy.types.Context, Pairs, int, int], Bake]


def begin_file(
    operator: "ISOCHOR_OT_bake", context: bpy.types.Context, pairs: Pairs, frame_start: int, frame_end: int
) -> Bake:
    """PC2 or MDD, as the operator's format says."""
    plan = bake_file.Plan(operator.format, frame_start, frame_end, operator.samples)
    chosen = frames.targets([obj for obj, _modifier in pairs])
    return bake_file.bake(context, chosen, operator.paths([target.obj for target in chosen]), plan)


def begin_keys(
    _operator: "ISOCHOR_OT_bake", context: bpy.types.Context, pairs: Pairs, frame_start: int, frame_end: int
) -> Bake:
    """Shape keys of the mesh."""
    return bake_keys.bake(context, frames.targets([obj for obj, _modifier in pairs]), frame_start, frame_end)


def begin_lattice(
    _operator: "ISOCHOR_OT_bake", context: bpy.types.Context, pairs: Pairs, frame_start: int, frame_end: int
) -> Bake:
    """Blender's own Lattice modifier."""
    return bake_lattice.bake(context, frames.targets([obj for obj, _modifier in pairs]), frame_start, frame_end)


FORMATS = (
    Format("PC2", "Point Cache (PC2)", "A file that a Mesh Cache modifier plays; the format of 3ds Max", begin_file),
    Format("MDD", "Point Cache (MDD)", "A file that a Mesh Cache modifier plays; the format of LightWave", begin_file),
    Format("SHAPE_KEYS", "Shape Keys", "A key of the mesh for each frame; other programs read them", begin_keys),
    Format(
        "LATTICE",
        "Native Lattice",
        "Blender's own Lattice modifier with the corrected points, where it can hold the very same deformation",
        begin_lattice,
    ),
)


class ISOCHOR_OT_bake(Stepping, FrameRange, bpy.types.Operator):
    """Record the deformed mesh over a range of frames, so that it plays and renders without this add-on. The Volume
    Lattice is switched off and kept"""

    bl_idname = "isochor.bake"
    bl_label = "Bake Volume Lattice"
    bl_options = {"REGISTER", "UNDO"}

    format: bpy.props.EnumProperty(
        name="Format", description="What to record to", items=[found[:3] for found in FORMATS]
    )
    samples: bpy.props.IntProperty(
        name="Samples",
        description="Samples to a frame, for files: between them points move in straight lines, also in motion blur",
        default=1,
        min=1,
        max=bake_file.FASTEST,
    )
    directory: bpy.props.StringProperty(
        name="Folder",
        description="Where the files go, for files: each is named after its object",
        subtype="DIR_PATH",
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    filepath: bpy.props.StringProperty(
        name="File",
        description="The file itself, where one object is baked; empty for one in the folder",
        subtype="FILE_PATH",
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if chosen_modifiers(context):
            return True
        cls.poll_message_set("Select a mesh with a Volume Lattice first")
        return False

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self.take_frames(context.scene)
        if not self.directory:
            self.directory = cache_places.default_folder()
        if bpy.app.background:
            return self.execute(context)
        self._with_progress = True
        return context.window_manager.invoke_props_dialog(self, width=380, confirm_text="Bake")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        names = ["format", "frame_start", "frame_end"]
        for name in [*names, "samples", "directory"] if self.format in SUFFIXES else names:
            layout.prop(self, name)

    def execute(self, context: bpy.types.Context) -> set[str]:
        chosen = next(found for found in FORMATS if found.identifier == self.format)
        try:
            bake = chosen.begin(self, context, chosen_modifiers(context), *self.take_frames(context.scene))
        except problem.Problem as trouble:
            self.report({"ERROR"}, words.reported(trouble.sentence))
            return {"CANCELLED"}
        return self.run(context, bake)

    def paths(self, objects: list[bpy.types.Object]) -> list[Path]:
        """A file for each object. Raises Problem where none can be told."""
        if self.filepath:
            if len(objects) > 1:
                raise problem.Problem(
                    Sentence("One file is given for {count} objects: give a folder instead.", count=len(objects))
                )
            path = cache_places.absolute(self.filepath)
            suffix = SUFFIXES[self.format]
            return [path if path.suffix.lower() == suffix else path.with_name(path.name + suffix)]
        folder = self.directory or cache_places.default_folder()
        if not folder:
            raise problem.Problem(
                "The .blend is not saved yet, so there is no folder beside it: save it, or give a folder."
            )
        return cache_places.in_folder(objects, cache_places.absolute(folder), self.format)


class ISOCHOR_OT_free_bake(bpy.types.Operator):
    """Take the baked playback off and switch the Volume Lattice on again. Files on the disk stay"""

    bl_idname = "isochor.free_bake"
    bl_label = "Free Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if baked_objects(context):
            return True
        cls.poll_message_set("Select a mesh whose Volume Lattice is baked first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = baked_objects(context)
        linked = [obj.name for obj in objects if not obj.is_editable]
        if linked:
            self.report({"ERROR"}, words.reported(problem.foreign(", ".join(linked))))
            return {"CANCELLED"}
        for obj in objects:
            baked.switch_back(obj)
        return {"FINISHED"}


def baked_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Those meant, of which a bake plays, also where the Volume Lattice is gone."""
    users = [obj for obj, _modifier in chosen_modifiers(context)]
    return [obj for obj in dict.fromkeys([*chosen_objects(context), *users]) if baked.is_playing(obj)]


CLASSES = (ISOCHOR_OT_bake, ISOCHOR_OT_free_bake)


def register() -> None:
    """Makes the operators known."""
    for found in CLASSES:
        bpy.utils.register_class(found)


def unregister() -> None:
    """Takes them back, last first."""
    for found in reversed(CLASSES):
        bpy.utils.unregister_class(found)
