# SPDX-License-Identifier: GPL-3.0-or-later
"""Isochor: a lattice modifier that keeps the volume."""

from . import languages
from .tool import command_line, handlers
from .ui import (
    adding,
    animate_panel,
    applying,
    bake_panel,
    baking,
    bend_empty,
    binding,
    binding_panel,
    converting,
    fitting,
    measuring,
    menus,
    mirroring,
    overlay,
    physics,
    pin_panel,
    pinning,
    points,
    preferences,
    refining,
    removing,
    sidebar,
    simulating,
    squash_ground,
    squash_speed,
    twist_bone,
    tying,
    volume_curve,
)

DRIVING = (squash_ground, squash_speed, twist_bone, bend_empty)
RESULTS = (points, measuring, baking, applying)
SHAPING = (adding, converting, fitting, refining, binding, mirroring, tying, pinning)
OPERATORS = (*SHAPING, *DRIVING, simulating, *RESULTS, removing)
PANELS = (sidebar, binding_panel, pin_panel, animate_panel, physics, bake_panel, overlay, volume_curve)
PARTS = (languages, preferences, handlers, *OPERATORS, menus, *PANELS, command_line)


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
