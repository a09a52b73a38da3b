# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's panel "Volume Curve", and the operator isochor.volume_image."""

import bpy

from ..core.volume_curve import VolumeCurve, farthest
from ..core.words import Sentence, sentence
from ..tool import curve_picture, stack, volume_curve, words
from .choosing import active_object, chosen_modifiers
from .measuring import ISOCHOR_OT_measure_volume

MARGINS, UNIT, PADDING = 54.0, 20.0, 8.0
"""Pixels, at interface scale 1: what stands beside a picture in the sidebar, the height of a button, and how much
smaller the picture is than the square that Blender keeps for it."""


class ISOCHOR_OT_volume_image(bpy.types.Operator):
    """Make an image of the measured volume curve, to be opened in an Image Editor and saved from there"""

    bl_idname = "isochor.volume_image"
    bl_label = "Volume Curve to Image"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if measured(context):
            return True
        cls.poll_message_set("Measure the volume first")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        images = [curve_picture.image(obj, curve) for obj, curve in measured(context)]
        for image in images:
            text = Sentence("The image “{name}” can be opened in an Image Editor", name=image.name)
            self.report({"INFO"}, words.reported(text))
        show(context, images[0])
        return {"FINISHED"}


def measured(context: bpy.types.Context) -> list[tuple[bpy.types.Object, VolumeCurve]]:
    """The objects that are meant and have a curve."""
    found = [(obj, volume_curve.read(modifier)) for obj, modifier in chosen_modifiers(context)]
    return [(obj, curve) for obj, curve in found if curve is not None]


def show(context: bpy.types.Context, image: bpy.types.Image) -> None:
    """Opens the image in Image Editors of this window that show none."""
    for area in context.screen.areas if context.screen is not None else ():
        if area.type == "IMAGE_EDITOR" and area.spaces.active.image is None:
            area.spaces.active.image = image


class VIEW3D_PT_isochor_volume_curve(bpy.types.Panel):
    """The volume over a range of frames, before and after the correction"""

    bl_label = "Volume Curve"
    bl_parent_id = "VIEW3D_PT_isochor"
    bl_category = "Isochor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 21

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(chosen_modifiers(context))

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = active_object(context)
        modifiers = stack.ours(obj) if obj is not None and obj.type == "MESH" else []
        pairs = [(obj, modifier) for modifier in modifiers] or chosen_modifiers(context)
        for owner, modifier in pairs:
            curve = volume_curve.read(modifier)
            if curve is not None:
                draw_curve(layout.column(), context, owner, modifier, curve)
        row = layout.row(align=True)
        row.operator(ISOCHOR_OT_measure_volume.bl_idname, text="Measure", icon="FCURVE")
        row.operator(ISOCHOR_OT_volume_image.bl_idname, text="To Image", icon="IMAGE_DATA")


def draw_curve(
    layout: bpy.types.UILayout,
    context: bpy.types.Context,
    obj: bpy.types.Object,
    modifier: bpy.types.NodesModifier,
    curve: VolumeCurve,
) -> None:
    """The picture of one curve, as wide as the sidebar, and its worst frames in numbers."""
    layout.label(text=f"{obj.name}: {modifier.name}", translate=False)
    scale = context.preferences.system.ui_scale
    width = max(180.0, context.region.width - MARGINS * scale)
    side = int(width - PADDING * scale)
    name = f"{obj.session_uid} {modifier.persistent_uid}"
    look = curve_picture.look_of_theme(context)
    icon = curve_picture.preview(name, curve, side, look, max(1, round(scale)))
    layout.template_icon(icon_value=icon, scale=width / (UNIT * scale))
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name, value in rows(curve):
        grid.label(text=words.shown(name), translate=False)
        grid.label(text=words.shown(value), translate=False)


def rows(curve: VolumeCurve) -> list[tuple[str, str]]:
    """Name and value of each number."""
    return [
        (sentence("Frames"), Sentence("{first} to {last}", first=curve.frames[0], last=curve.frames[-1])),
        (sentence("Lattice alone"), at_worst(f"{farthest(curve.before_percent) - 100.0:+.1f}")),
        (sentence("Corrected"), at_worst(f"{farthest(curve.after_percent) - 100.0:+.1e}")),
    ]


def at_worst(percent: str) -> Sentence:
    """The percentage in the worst frame."""
    return Sentence("{percent} % at worst", percent=percent)


CLASSES = (ISOCHOR_OT_volume_image, VIEW3D_PT_isochor_volume_curve)


def register() -> None:
    """Makes the operator and the panel known."""
    curve_picture.register()
    for found in CLASSES:
        bpy.utils.register_class(found)


def unregister() -> None:
    """Takes them back, last first."""
    for found in reversed(CLASSES):
        bpy.utils.unregister_class(found)
    curve_picture.unregister()
