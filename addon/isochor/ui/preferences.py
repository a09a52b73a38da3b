# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's preferences: what computes."""

import bpy

import isochor

from ..tool import device, handlers

DEVICES = (
    (device.AUTO, "Auto", "A graphics card where measuring shows it to be faster for the mesh at hand, else the CPU"),
    (device.GPU, "GPU", "The best graphics card, or a software rasteriser where there is none"),
    (device.CPU, "CPU", "All cores of the processor"),
    (device.NAMED, "Named", "The adapter of the name below"),
)


def adapters(_owner: object, _context: bpy.types.Context, typed: str) -> list[str]:
    """Names of the adapters of this machine that hold what was typed."""
    names = [found.name for found in isochor.devices() if found.kind != "cpu"]
    return [name for name in names if typed.lower() in name.lower()]


def changed(_owner: object, _context: bpy.types.Context) -> None:
    """Has everything computed anew on what was chosen."""
    handlers.recompute()


class IsochorPreferences(bpy.types.AddonPreferences):
    """What computes"""

    bl_idname = device.PACKAGE

    device: bpy.props.EnumProperty(name="Device", description="What computes", items=DEVICES, update=changed)
    adapter: bpy.props.StringProperty(
        name="Adapter", description="Name of an adapter of this machine", search=adapters, update=changed
    )

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "device")
        row = layout.row()
        row.enabled = self.device == device.NAMED
        row.prop(self, "adapter")
        layout.label(text="Where a GPU is missing or fails, the CPU computes the same frame.")


def register() -> None:
    """Adds the preferences."""
    bpy.utils.register_class(IsochorPreferences)


def unregister() -> None:
    """Takes them away."""
    bpy.utils.unregister_class(IsochorPreferences)
