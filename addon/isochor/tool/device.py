# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user's preferences choose: device, precision, memory."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

AUTO, GPU, CPU, NAMED = "AUTO", "GPU", "CPU", "NAMED"
PACKAGE = (__package__ or "").rpartition(".")[0]
"""Name of the extension, under which Blender keeps its preferences."""

SINGLE, DOUBLE = "SINGLE", "DOUBLE"

MEGABYTE = 1 << 20

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
    preferences = of_user()
    if preferences is None:
        return WORDS[AUTO]
    if preferences.device == NAMED:
        return str(preferences.adapter) or WORDS[AUTO]
    return WORDS[preferences.device]


def is_double() -> bool:
    """Whether to compute in float64."""
    preferences = of_user()
    return preferences is not None and preferences.precision == DOUBLE


def memory_limit() -> int:
    """Bytes that computed frames may take."""
    preferences = of_user()
    return 0 if preferences is None else preferences.memory * MEGABYTE


def of_user() -> bpy.types.AddonPreferences | None:
    """The extension's preferences, or None where it is not enabled."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    return addon.preferences if addon is not None else None
