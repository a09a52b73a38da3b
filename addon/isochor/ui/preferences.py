# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: what computes, how precisely, and how many frames stay in memory."""

import bpy

import isochor

from ..core.words import Sentence
from ..tool import device, frame_memory, handlers, state, words

DEVICES = (
    (device.AUTO, "Auto", "A graphics card where measuring shows it to be faster for the mesh at hand, else the CPU"),
    (device.GPU, "GPU", "The best graphics card, or a software rasteriser where there is none"),
    (device.CPU, "CPU", "All cores of the processor"),
    (device.NAMED, "Named", "The adapter of the name below"),
)

PRECISIONS = (
    (device.SINGLE, "Single", "Vertices in the precision that Blender stores, the volume in more. The faster one"),
    (
        device.DOUBLE,
        "Double",
        "Everything in double precision, rounded once at the end: each vertex comes out two to three times closer to"
        " its exact place, the volume no closer. A frame of 35 thousand vertices took 4.5 ms instead of 2.9 on two"
        " cores. Always on the CPU",
    ),
)


def adapters(_owner: object, _context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the adapters of this machine that hold what was typed."""
    names = [found.name for found in isochor.devices() if found.kind != "cpu"]
    return [name for name in names if typed.lower() in name.lower()]


def changed(_owner: object, _context: bpy.types.Context) -> None:
    """Has everything computed anew on what was chosen."""
    handlers.recompute()


def memory_changed(_owner: object, _context: bpy.types.Context) -> None:
    """Lets go of what no longer fits."""
    state.change_memory(frame_memory.resize)


class ISOCHOR_OT_clear_memory(bpy.types.Operator):
    """Let go of all computed frames that are kept in memory; they are computed again when they are next shown"""

    bl_idname = "isochor.clear_memory"
    bl_label = "Clear Frame Memory"
    bl_options = {"REGISTER"}

    def execute(self, _context: bpy.types.Context) -> set[str]:
        state.change_memory(frame_memory.clear)
        return {"FINISHED"}


class IsochorPreferences(bpy.types.AddonPreferences):
    """What computes, how precisely, and how many frames stay in memory"""

    bl_idname = device.PACKAGE

    device: bpy.props.EnumProperty(name="Device", description="What computes", items=DEVICES, update=changed)
    adapter: bpy.props.StringProperty(
        name="Adapter", description="Name of an adapter of this machine", search=adapters, update=changed
    )
    precision: bpy.props.EnumProperty(
        name="Precision", description="Digits to compute with", items=PRECISIONS, update=changed
    )
    memory: bpy.props.IntProperty(
        name="Frame Memory",
        description="Megabytes for frames of the viewport that were computed twice, so that playing them in a loop or"
        " scrubbing over them computes nothing from then on; 0 keeps none",
        default=256,
        min=0,
        soft_max=8192,
        update=memory_changed,
    )

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "device")
        row = layout.row()
        row.enabled = self.device == device.NAMED
        row.prop(self, "adapter")
        layout.prop(self, "precision")
        layout.prop(self, "memory", text="Frame Memory (MB)")
        row = layout.row()
        row.label(text=memory_used())
        row.operator(ISOCHOR_OT_clear_memory.bl_idname, text="Clear", icon="TRASH")
        layout.label(text="Where a GPU is missing or fails, the CPU computes the same frame.")


def memory_used() -> str:
    """How much of the frame memory is in use, in words."""
    count, used = frame_memory.used()
    megabytes = f"{used / device.MEGABYTE:.1f}"
    return words.shown(Sentence("{count} frames kept, {megabytes} MB", count=count, megabytes=megabytes))


CLASSES = (ISOCHOR_OT_clear_memory, IsochorPreferences)


def register() -> None:
    """Adds the preferences."""
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    """Takes them away."""
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
