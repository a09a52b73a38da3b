# SPDX-License-Identifier: GPL-3.0-or-later
"""The device that the user's preferences choose."""

import bpy

AUTO, GPU, CPU, NAMED = "AUTO", "GPU", "CPU", "NAMED"
PACKAGE = (__package__ or "").rpartition(".")[0]
"""Name of the extension, under which Blender keeps its preferences."""

WORDS = {AUTO: "auto", GPU: "gpu", CPU: "cpu"}


def chosen() -> str:
    """What the native library takes as a device: "auto", "gpu", "cpu" or the name of an adapter."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    preferences = addon.preferences if addon is not None else None
    if preferences is None:
        return WORDS[AUTO]
    if preferences.device == NAMED:
        return str(preferences.adapter) or WORDS[AUTO]
    return WORDS[preferences.device]
