# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey can do with curves, hair, point clouds, texts, and the points of surfaces and lattices."""

from pathlib import Path

import bpy
import numpy as np
import scenes
import things
from monkey_actions import NOTHING
from monkey_operators import attempt
from monkey_scene import FRAMES, Scene

MAKERS = {
    "CURVE": lambda: things.curve("BEZIER", things.path(4)),
    "CURVES": things.hair,
    "POINTCLOUD": things.cloud,
    "FONT": lambda: things.text("a"),
    "SURFACE": lambda: _surface(),
}
POINTED = ("SURFACE", "CURVE", "LATTICE")


def make_thing(scene: Scene, _folder: Path) -> str:
    """One of each kind at most."""
    there = {obj.type for obj in bpy.context.view_layer.objects}
    kinds = [kind for kind in MAKERS if kind not in there]
    if not kinds or bpy.context.mode != "OBJECT":
        return NOTHING
    return f"make {MAKERS[scene.random.choice(kinds)]().name}"


def add_to_thing(scene: Scene, _folder: Path) -> str:
    obj = _some(scene, [kind for kind in MAKERS if kind != "SURFACE"])
    if obj is None or len(obj.modifiers) > 1:
        return NOTHING
    scenes.choose(obj)
    return f"add {obj.name} {attempt(bpy.ops.isochor.add, flat=scene.random.random() < 0.5)}"


def change_thing(scene: Scene, _folder: Path) -> str:
    """Types another text, moves points of a curve, gives or takes thickness."""
    obj = _some(scene, ["CURVE", "FONT", "SURFACE"])
    if obj is None or obj.mode != "OBJECT" or not obj.data.is_editable:
        return NOTHING
    if obj.type == "FONT":
        obj.data.body = scene.random.choice(("a", "Iso", "", "b c"))
    if obj.type == "CURVE":
        obj.data.bevel_depth = scene.random.choice((0.0, 0.1))
    for spline in () if obj.type == "FONT" else obj.data.splines:
        for point in (*spline.points, *spline.bezier_points):
            point.co[scene.random.randint(0, 2)] += scene.random.uniform(-0.05, 0.05)
    return f"change {obj.name}"


def set_input_of_thing(scene: Scene, _folder: Path) -> str:
    users = [obj for obj in _all(list(MAKERS)) if scenes.part("tool.stack").ours(obj)]
    if not users:
        return NOTHING
    obj = scene.random.choice(users)
    modifier = scene.random.choice(scenes.part("tool.stack").ours(obj))
    uniform, choice = scene.random.uniform, scene.random.choice
    name, value = choice(
        (
            ("Strength", uniform(0.0, 1.0)),
            ("Squash", uniform(0.5, 1.5)),
            ("Twist", uniform(-1.0, 1.0)),
            ("Vertex Group", choice(("", "radius", "missing"))),
            ("Islands", choice((True, False))),
            ("Close Holes", choice((True, False))),
            ("Outside", choice(("Keep", "Extend"))),
        )
    )
    scenes.set_input(modifier, name, value)
    return f"set {obj.name} {name} {value}"


def take_from_thing(scene: Scene, _folder: Path) -> str:
    users = [obj for obj in _all(list(MAKERS)) if scenes.part("tool.stack").ours(obj)]
    if not users:
        return NOTHING
    scenes.choose(scene.random.choice(users))
    name = scene.random.choice(("remove", "set_rest", "clear_rest", "fit_lattice", "bake", "apply", "measure_volume"))
    return f"{name} {attempt(getattr(bpy.ops.isochor, name))}"


def deform_points(scene: Scene, _folder: Path) -> str:
    return _on_points(
        scene, bpy.ops.isochor.deform_points, anew=scene.random.random() < 0.2, strength=scene.random.uniform(0.2, 1.0)
    )


def bake_points(scene: Scene, _folder: Path) -> str:
    first = scene.random.randint(1, FRAMES - 3)
    return _on_points(scene, bpy.ops.isochor.bake_points, frame_start=first, frame_end=first + 2)


def restore_points(scene: Scene, _folder: Path) -> str:
    return _on_points(scene, bpy.ops.isochor.restore_points)


def _on_points(scene: Scene, operator, **properties) -> str:
    obj, lattice = _some(scene, POINTED), scene.some_lattice()
    if obj is None or lattice is None:
        return NOTHING
    scenes.choose(lattice)
    obj.select_set(True)
    return f"{operator.idname_py()} {obj.name} by {lattice.name} {attempt(operator, **properties)}"


def wrong_points(_scene: Scene) -> str:
    """What of the things shows points that are nowhere, or nothing."""
    for obj in _all(list(MAKERS)):
        if not obj.visible_get():
            continue
        for name, points in things.shown(obj).items():
            if not np.isfinite(points).all():
                return f"{obj.name} has {name} that are nowhere"
    return ""


def _surface() -> bpy.types.Object:
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    return bpy.context.object


def _all(kinds) -> list[bpy.types.Object]:
    return [obj for obj in bpy.context.view_layer.objects if obj.type in kinds]


def _some(scene: Scene, kinds) -> bpy.types.Object | None:
    found = [obj for obj in _all(kinds) if obj.visible_get()]
    return scene.random.choice(found) if found else None


ACTIONS = {
    make_thing: 2,
    add_to_thing: 3,
    change_thing: 2,
    set_input_of_thing: 4,
    take_from_thing: 2,
    deform_points: 2,
    bake_points: 1,
    restore_points: 2,
}
"""How often each is done, in proportion."""
