# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey can do with Blender itself: edit, key, copy, delete, hide, undo, save. Each returns its name."""

from pathlib import Path
from typing import Any

import bmesh
import bpy
import scenes
from monkey_scene import FRAMES, Scene

AT_MOST = 6
"""Meshes in the scene; copying stops there."""
NOTHING = "nothing"


def move_points(scene: Scene, _folder: Path) -> str:
    lattice = scene.some_lattice()
    if lattice is None:
        return NOTHING
    amount = scene.random.choice((0.05, 0.1, 0.2))
    for point in lattice.data.points:
        if scene.random.random() < 0.3:
            point.co_deform = [value + scene.random.uniform(-amount, amount) for value in point.co_deform]
    lattice.data.update_tag()
    return f"move {lattice.name}"


def change_frame(scene: Scene, _folder: Path) -> str:
    frame = scene.random.randint(1, FRAMES)
    bpy.context.scene.frame_set(frame)
    return f"frame {frame}"


def undo(scene: Scene, _folder: Path) -> str:
    return _history(scene, bpy.ops.ed.undo, "undo")


def redo(scene: Scene, _folder: Path) -> str:
    return _history(scene, bpy.ops.ed.redo, "redo")


def _history(scene: Scene, operator: Any, name: str) -> str:
    times = scene.random.randint(1, 4)
    for _ in range(times):
        if not operator.poll():
            break
        operator()
    return f"{name} {times}"


def key_input(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None:
        return NOTHING
    modifier = scene.some_modifier(user)
    name = scene.random.choice(("Preserve", "Target", "Strength"))
    scenes.set_input(modifier, name, scene.random.uniform(0.6, 1.0))
    place = scenes.part("tool.sockets").data_path(modifier, name)
    path = f'modifiers["{bpy.utils.escape_identifier(modifier.name)}"]{"" if place[0] == "[" else "."}{place}'
    user.keyframe_insert(path, frame=scene.random.randint(1, FRAMES))
    return f"key {user.name} {name}"


def key_lattice(scene: Scene, _folder: Path) -> str:
    lattice = scene.some_lattice()
    if lattice is None:
        return NOTHING
    lattice.keyframe_insert("location", frame=scene.random.randint(1, FRAMES))
    return f"key {lattice.name}"


def copy(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None or len(scene.meshes()) >= AT_MOST:
        return NOTHING
    twin = mesh.copy()
    if scene.random.random() < 0.5:
        twin.data = mesh.data.copy()
    bpy.context.scene.collection.objects.link(twin)
    twin.location.y += 1.0
    return f"copy {mesh.name}"


def delete(scene: Scene, _folder: Path) -> str:
    pool = [*scene.meshes()[1:], *scene.lattices()]
    if len(pool) < 3:
        return NOTHING
    doomed = scene.random.choice(pool)
    name = doomed.name
    bpy.data.objects.remove(doomed)
    return f"delete {name}"


def edit_mesh(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None:
        return NOTHING
    scenes.choose(mesh)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.update()
    grown = 1.0 + scene.random.uniform(-0.1, 0.1)
    edited = bmesh.from_edit_mesh(mesh.data)
    bmesh.ops.scale(edited, vec=(grown, grown, grown), verts=edited.verts)
    bmesh.update_edit_mesh(mesh.data)
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="OBJECT")
    return f"edit {mesh.name}"


def edit_lattice(scene: Scene, _folder: Path) -> str:
    lattice = scene.some_lattice()
    if lattice is None or not lattice.visible_get():
        return NOTHING
    scenes.choose(lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(scene.random.randint(1, FRAMES))
    bpy.ops.object.mode_set(mode="OBJECT")
    return f"edit {lattice.name}"


def choose(scene: Scene, _folder: Path) -> str:
    visible = [obj for obj in bpy.context.view_layer.objects if obj.visible_get()]
    if not visible:
        return NOTHING
    chosen = scene.random.choice(visible)
    scenes.choose(chosen)
    return f"choose {chosen.name}"


def reload(_scene: Scene, folder: Path) -> str:
    place = str(folder / "monkey.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place, check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=place)
    return "reload"


def hide(scene: Scene, _folder: Path) -> str:
    obj = scene.random.choice(list(bpy.context.view_layer.objects))
    obj.hide_set(not obj.hide_get())
    obj.hide_viewport = scene.random.random() < 0.2
    return f"hide {obj.name}"


def other_modifier(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None:
        return NOTHING
    others = [modifier for modifier in mesh.modifiers if modifier.type != "NODES"]
    if others:
        mesh.modifiers.remove(scene.random.choice(others))
        return f"unmodify {mesh.name}"
    kind = scene.random.choice(("SUBSURF", "SMOOTH", "ARRAY", "DECIMATE", "WAVE", "SOLIDIFY"))
    modifier = mesh.modifiers.new(kind.title(), kind)
    mesh.modifiers.move(len(mesh.modifiers) - 1, scene.random.randrange(len(mesh.modifiers)))
    return f"modify {mesh.name} {modifier.type}"


def switch_modifier(scene: Scene, _folder: Path) -> str:
    mesh = scene.some_mesh()
    if mesh is None or not mesh.modifiers:
        return NOTHING
    modifier = scene.random.choice(list(mesh.modifiers))
    modifier.show_viewport = not modifier.show_viewport
    return f"switch {mesh.name} {modifier.name}"


def move_object(scene: Scene, _folder: Path) -> str:
    obj = scene.random.choice(list(bpy.context.scene.objects))
    obj.location = [value + scene.random.uniform(-0.3, 0.3) for value in obj.location]
    if scene.random.random() < 0.3:
        obj.scale = [value * scene.random.uniform(0.8, 1.25) for value in obj.scale]
    return f"shift {obj.name}"


def change_resolution(scene: Scene, _folder: Path) -> str:
    lattice = scene.some_lattice()
    if lattice is None or lattice.data.shape_keys is not None:
        return NOTHING
    lattice.data.points_u = scene.random.choice((1, 2, 3, 4, 6))
    return f"resolution {lattice.name}"


def rename(scene: Scene, _folder: Path) -> str:
    user = scene.some_user()
    if user is None:
        return NOTHING
    scene.some_modifier(user).name = scene.random.choice(("Volume Lattice", "Squash", "ü", 'with "quotes"'))
    user.name = scene.random.choice(("Ball", "Kugel", "Twin"))
    return f"rename {user.name}"


ACTIONS = {
    move_points: 12,
    change_frame: 10,
    undo: 8,
    redo: 5,
    key_input: 2,
    key_lattice: 2,
    copy: 3,
    delete: 1,
    edit_mesh: 3,
    edit_lattice: 3,
    choose: 4,
    reload: 1,
    hide: 2,
    other_modifier: 3,
    switch_modifier: 2,
    move_object: 3,
    change_resolution: 2,
    rename: 2,
}
"""How often each is done, in proportion."""
