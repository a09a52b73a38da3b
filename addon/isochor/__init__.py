# SPDX-License-Identifier: GPL-3.0-or-later
"""Isochor: a lattice modifier that keeps the volume."""

from .tool import handlers
from .ui import adding, menus, physics, preferences, removing, sidebar, simulating

PARTS = (preferences, handlers, adding, removing, simulating, menus, sidebar, physics)


def register() -> None:
    """Registers every part in order; where one fails, takes back those before it and says why."""
    done = []
    try:
        for part in PARTS:
            part.register()
            done.append(part)
    except Exception:
        for part in reversed(done):
            part.unregister()
        raise


def unregister() -> None:
    """Unregisters every part, last first."""
    for part in reversed(PARTS):
        part.unregister()
