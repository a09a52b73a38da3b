# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey can do with the extension: every operator and input of ours. Each returns its name."""

from pathlib import Path
from typing import Any

import bpy
import scenes
from monkey_actions import NOTHING
from monkey_scene import FRAMES, Scene

MENUS = {
    "Reference": ("Rest", "Incoming"),
    "Space": ("Global", "Object", "Lattice", "Custom"),
    "Method": ("Balanced", "Sweep", "Gradient", "Nearest"),
    "Cost": ("Points", "Surface", "Bending"),
    "Basis": ("Bernstein", "B-Spline", "Blender"),
    "Outside": ("Keep", "Extend"),
    "Joint": ("Free", "C0", "C1", "C2"),
    "Axis": ("X", "Y", "Z"),
    "Pivot": ("Bottom", "Centre", "Top"),
}
GROUP = "Some"
"""Vertex group of lattices and of meshes."""
MODIFIERS_AT_MOST = 3


def attempt(operator: Any, **properties: Any) -> str:
    """Calls one of our operators; a refusal in plain words is as good as a success, a traceback is not."""
    try:
        return next(iter(operator(**properties))).lower()
    except RuntimeError as refusal:
        if "Traceback" in str(refusal):
            raise
        return "refused"


def on_users(scene: Scene, operator: Any, **properties: Any) -> str:
    """Calls it with one or two meshes that have a Volume Lattice selected, or with a lattice."""
    users = scene.users()
    if not users:
        return NOTHING
    chosen = scene.random.sample(users, min(len(users), scene.random.choice((1, 1, 2))))
    lattice = scene.some_lattice()
    scenes.choose(lattice if lattice is not None and scene.random.random() < 0.2 else chosen[0])
    for other in chosen[1:]:
        other.select_set(True)
    names = " ".join(obj.name for obj in bpy.context.selected_objects)
    return f"{operator.idname_py()} {names} {attempt(operator, **properties)}"


def add(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None or len(mesh.modifiers) >= MODIFIERS_AT_MOST:
        return NOTHING
    scenes.choose(mesh)
    side, basis = scene.random.choice((2, 3, 4, 5)), scene.random.choice(("BERNSTEIN", "BSPLINE"))
    answer = attempt(
        bpy.ops.isochor.add,
        resolution=(side, scene.random.choice((2, 4)), side),
        basis=basis,
        fit=scene.random.choice(("LOCAL", "WORLD", "ORIENTED")),
        margin=scene.random.choice((0.0, 0.05, 0.5)),
    )
    return f"add {mesh.name} {basis} {side} {answer}"


def remove(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.remove)


def set_rest(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.set_rest)


def clear_rest(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.clear_rest)


def fit_again(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.fit_lattice, margin=scene.random.choice((0.0, 0.2)))


def refine(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.fit_lattice, resolution=(scene.random.choice((3, 5, 6)), 0, 0))


def mirror(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.mirror_lattice, axis=scene.random.choice("XYZ"))


def measure(scene: Scene, _folder: Path) -> str:
    first = scene.random.randint(1, FRAMES - 3)
    return on_users(scene, bpy.ops.isochor.measure_volume, frame_start=first, frame_end=first + 3)


def picture_of_curve(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.volume_image)


def bake(scene: Scene, folder: Path) -> str:
    kind = scene.random.choice(("PC2", "MDD", "SHAPE_KEYS", "LATTICE"))
    first = scene.random.randint(1, FRAMES - 3)
    return on_users(
        scene, bpy.ops.isochor.bake, format=kind, frame_start=first, frame_end=first + 2, directory=str(folder)
    )


def free_bake(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.free_bake)


def apply(scene: Scene, _folder: Path) -> str:
    as_key = scene.random.random() < 0.5
    return on_users(
        scene,
        bpy.ops.isochor.apply,
        as_shape_key=as_key,
        keep_modifier=as_key and scene.random.random() < 0.5,
        single_user=scene.random.random() < 0.5,
    )


def simulate(scene: Scene, _folder: Path) -> str:
    first = scene.random.randint(1, FRAMES - 4)
    return on_users(scene, bpy.ops.isochor.simulate, frame_start=first, frame_end=first + 4, substeps=1)


def free_simulation(scene: Scene, _folder: Path) -> str:
    return on_users(scene, bpy.ops.isochor.free_simulation)


def drive(scene: Scene, _folder: Path) -> str:
    other = scene.some_mesh()
    name = "" if other is None else other.name
    return scene.random.choice(
        (
            lambda: on_users(scene, bpy.ops.isochor.squash_from_ground, ground=name),
            lambda: on_users(scene, bpy.ops.isochor.squash_from_speed, frame_start=1, frame_end=4),
            lambda: on_users(scene, bpy.ops.isochor.bend_from_empty, empty=name),
            lambda: on_users(scene, bpy.ops.isochor.twist_from_bone, armature=name),
        )
    )()


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
        ("Squash", choice((1.0, uniform(0.5, 1.5)))),
        ("Taper", choice((0.0, uniform(-0.5, 0.5)))),
        ("Twist", choice((0.0, uniform(-2.0, 2.0)))),
        ("Bend", choice((0.0, uniform(-1.5, 1.5)))),
        ("Bend Direction", uniform(-3.0, 3.0)),
        ("Lattice", choice([None, *scene.lattices() * 3])),
        ("Frame", choice([None, *scene.empties(), *scene.lattices()])),
    ]
    return found + _values_of_bodies(scene)


def _values_of_bodies(scene: Scene) -> list[tuple[str, Any]]:
    """Of the inputs that divide the volume or lead the correction."""
    uniform, choice = scene.random.uniform, scene.random.choice
    return [
        ("Islands", choice((True, False))),
        ("Close Holes", choice((True, False))),
        ("Region", choice(("", "", GROUP, "missing"))),
        ("Region Target", uniform(0.8, 1.2)),
        ("Stiffness", choice(("", "", GROUP, "missing"))),
        ("Where Lost", choice((0.0, uniform(0.0, 1.0)))),
        ("Unfolded", choice((True, False))),
        ("Falloff", choice((0.0, uniform(0.2, 2.0)))),
        ("Weights", choice(("", "", GROUP, "missing"))),
        ("Heaviest", choice((10.0, uniform(0.1, 20.0)))),
    ]


def assign_group(scene: Scene, _folder: Path) -> str:
    """Puts some points of a lattice, or the upper vertices of a mesh, into the group that Stiffness and Region name."""
    pool = [obj for obj in (scene.some_lattice(), scene.some_mesh()) if obj is not None and obj.mode == "OBJECT"]
    if not pool:
        return NOTHING
    obj = scene.random.choice(pool)
    group = obj.vertex_groups.get(GROUP) or obj.vertex_groups.new(name=GROUP)
    places = [point.co for point in obj.data.points] if obj.type == "LATTICE" else [v.co for v in obj.data.vertices]
    height = scene.random.uniform(-0.5, 0.5)
    chosen = [index for index, place in enumerate(places) if place.z > height]
    group.add(chosen, scene.random.choice((1.0, 0.5, 0.3)), "REPLACE")
    return f"group of {obj.name}"


ACTIONS = {
    add: 9,
    remove: 3,
    set_input: 14,
    assign_group: 2,
    set_rest: 3,
    clear_rest: 1,
    fit_again: 2,
    refine: 1,
    mirror: 2,
    measure: 1,
    picture_of_curve: 1,
    bake: 2,
    free_bake: 3,
    apply: 2,
    simulate: 1,
    free_simulation: 2,
    drive: 2,
}
"""How often each is done, in proportion."""
