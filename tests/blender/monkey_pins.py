# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey can do with pins, and whether what they hold is where it must be."""

from pathlib import Path

import bpy
import numpy as np
import scenes
from monkey_actions import NOTHING
from monkey_operators import attempt, on_users
from monkey_scene import SINGLE, Scene

FEW = 3
"""Vertices that are pinned at once, at most."""


def add_pin(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None or not len(user.data.vertices):
        return NOTHING
    scenes.choose(user)
    if scene.random.random() < 0.3:
        point = np.array(user.location) + [scene.random.uniform(-1.0, 1.0) for _ in range(3)]
        answer = attempt(
            bpy.ops.isochor.add_pin, where="POINT", point=point, snap=scene.random.random() < 0.5, follow=True
        )
        return f"add pin near {user.name} {answer}"
    count = len(user.data.vertices)
    chosen = scene.random.sample(range(count), min(count, scene.random.randint(1, FEW)))
    user.data.vertices.foreach_set("select", np.isin(np.arange(count), chosen))
    return f"add pin {user.name} {chosen} {attempt(bpy.ops.isochor.add_pin)}"


def move_pin(scene: Scene, _folder: Path) -> str:
    empties = scene.empties()
    if not empties:
        return NOTHING
    empty = scene.random.choice(empties)
    empty.location = [value + scene.random.uniform(-0.2, 0.2) for value in empty.location]
    if scene.random.random() < 0.2:
        empty.keyframe_insert("location", frame=scene.random.randint(1, 30))
    return f"move {empty.name}"


def copy_pin(scene: Scene, _folder: Path) -> str:
    empties = scene.empties()
    if not empties or len(empties) > FEW:
        return NOTHING
    empty = scene.random.choice(empties)
    twin = empty.copy()
    for collection in empty.users_collection:
        collection.objects.link(twin)
    return f"copy {empty.name}"


def delete_pin(scene: Scene, _folder: Path) -> str:
    empties = scene.empties()
    if not empties:
        return NOTHING
    empty = scene.random.choice(empties)
    name = empty.name
    bpy.data.objects.remove(empty)
    return f"delete {name}"


def bind_pins(scene: Scene, _folder: Path) -> str:
    user, empties = scene.some_user(), scene.empties()
    if user is None:
        return NOTHING
    scenes.choose(user)
    for empty in scene.random.sample(empties, min(len(empties), scene.random.randint(0, 2))):
        if empty.name in bpy.context.view_layer.objects:
            empty.select_set(True)
    return f"bind pins {user.name} {attempt(bpy.ops.isochor.bind_pins, anew=scene.random.random() < 0.3)}"


def remove_pins(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.remove_pins)


def share_collection(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None:
        return NOTHING
    held = scene.random.choice([None, *bpy.data.collections])
    scenes.set_input(scene.some_modifier(user), "Pins", held)
    return f"pins of {user.name} {None if held is None else held.name}"


def wrong_pin(scene: Scene) -> str:
    """What is wrong with where the surface of an object is held, or nothing."""
    for obj in scene.users():
        modifiers = scenes.part("tool.stack").active(obj, "VIEWPORT")
        last = obj.modifiers[-1]
        memory = scenes.part("tool.state").recall(obj, last)
        if obj.mode != "OBJECT" or not obj.visible_get() or last not in modifiers or memory is None:
            continue
        report = memory.report
        if not scenes.part("tool.stack").is_ours(last) or report.pins is None or report.result is None:
            continue
        shown = scenes.evaluated_positions(obj)
        reach = max(np.abs(shown).max(), np.abs(report.pins.targets).max(), np.abs(report.control).max())
        allowed = 32.0 * SINGLE * reach * np.abs(report.pins.metric).max()
        miss = report.pins.misses(shown).max()
        if not miss <= allowed:
            return f"{obj.name} misses a pin of {report.pins.names} by {miss:.1e}, allowed {allowed:.1e}"
    return ""


ACTIONS = {
    add_pin: 5,
    move_pin: 8,
    copy_pin: 1,
    delete_pin: 1,
    bind_pins: 3,
    remove_pins: 2,
    share_collection: 1,
}
"""How often each is done, in proportion."""
