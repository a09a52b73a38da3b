# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey can do with the extension: every operator and input of ours. Each returns its name."""

from pathlib import Path
from typing import Any

import bpy
import scenes
from monkey_actions import NOTHING
from monkey_scene import Scene

MENUS = {
    "Reference": ("Rest", "Incoming"),
    "Space": ("Global", "Object", "Lattice"),
    "Method": ("Balanced", "Sweep"),
    "Basis": ("Bernstein", "B-Spline"),
    "Outside": ("Keep", "Extend"),
}
MODIFIERS_AT_MOST = 3


def add(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None or len(mesh.modifiers) >= MODIFIERS_AT_MOST:
        return NOTHING
    scenes.choose(mesh)
    side, basis = scene.random.choice((2, 3, 4, 5)), scene.random.choice(("BERNSTEIN", "BSPLINE"))
    bpy.ops.isochor.add(
        resolution=(side, scene.random.choice((2, 4)), side),
        basis=basis,
        fit=scene.random.choice(("LOCAL", "WORLD", "ORIENTED")),
        margin=scene.random.choice((0.0, 0.05, 0.5)),
    )
    return f"add {mesh.name} {basis} {side}"


def remove(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None:
        return NOTHING
    scenes.choose(user)
    bpy.ops.isochor.remove()
    return f"remove {user.name}"


def set_input(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None:
        return NOTHING
    name, value = scene.random.choice(_values(scene))
    scenes.set_input(scene.some_modifier(user), name, value)
    return f"set {user.name} {name} {getattr(value, 'name', value)}"


def _values(scene: Scene) -> list[tuple[str, Any]]:
    uniform, choice = scene.random.uniform, scene.random.choice
    found: list[tuple[str, Any]] = [(name, choice(names)) for name, names in MENUS.items()]
    found += [("Reference", "Incoming"), ("Reference", "Incoming"), ("Preserve", 1.0), ("Strength", 1.0)]
    found += [
        ("Strength", uniform(0.0, 1.0)),
        ("Preserve", uniform(0.0, 1.0)),
        ("Target", uniform(0.7, 1.4)),
        ("Axes", choice(((1, 1, 1), (1, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0, 0)))),
        ("Vertex Group", choice(("", "", "missing"))),
        ("Lattice", choice([None, *scene.lattices() * 3])),
    ]
    return found


ACTIONS = {
    add: 7,
    remove: 3,
    set_input: 9,
}
"""How often each is done, in proportion."""
