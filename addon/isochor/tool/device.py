# SPDX-License-Identifier: GPL-3.0-or-later
"""The device that the user's preferences choose."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

AUTO, GPU, CPU, NAMED = "AUTO", "GPU", "CPU", "NAMED"
PACKAGE = (__package__ or "").rpartition(".")[0]
"""Name of the extension, under which Blender keeps its preferences."""

WORDS = {AUTO: "auto", GPU: "gpu", CPU: "cpu"}

_steady: list[bool] = []


@contextmanager
def steady() -> Iterator[None]:
    """Has "auto" mean the CPU, so that every process computes the same to the last bit."""
    _steady.append(True)
    try:
        yield
    finally:
        _steady.pop()


def chosen() -> str:
    """What the native library takes as a device: "auto", "gpu", "cpu" or the name of an adapter."""
    wanted = _preferred()
    return WORDS[CPU] if _steady and wanted == WORDS[AUTO] else wanted


def _preferred() -> str:
    addon = bpy.context.preferences.addons.get(PACKAGE)
    preferences = addon.preferences if addon is not None else None
    if preferences is None:
        return WORDS[AUTO]
    if preferences.device == NAMED:
        return str(preferences.adapter) or WORDS[AUTO]
    return WORDS[preferences.device]
