# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the monkey plays in: what there is to act on, and the volumes that must be right whatever it did."""

from random import Random
from typing import Any

import bpy
import numpy as np
import pieces
import scenes

TOLERANCE = 1e-6
FRAMES = 30
SINGLE = float(np.finfo(np.float32).eps)


class Scene:
    """A few closed meshes of different size; counts the volumes measured."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.measured = 0
        self.largest_error = 0.0
        scenes.empty_file()
        for place, name in enumerate(("Ball", "Twin", "Third")):
            ball = scenes.sphere(12, 8, name)
            ball.location.x = 3.0 * place
            ball.scale = (1.0, 1.0 + 0.2 * place, 1.0)
        bpy.context.scene.frame_end = FRAMES

    def wrong_volume(self) -> str:
        """What is wrong with the volume of an object that claims to keep it, or nothing."""
        for obj in self.users():
            found = kept(obj)
            if found is None:
                continue
            target, tolerance = found
            volume = scenes.evaluated_volume(obj)
            error = abs(volume - target) / abs(target)
            self.measured += 1
            self.largest_error = max(self.largest_error, error)
            if not error <= tolerance:
                return f"{obj.name} encloses {volume:.9g}, not {target:.9g}: {error:.1e} off, allowed {tolerance:.1e}"
        return ""

    def meshes(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.context.view_layer.objects if obj.type == "MESH"]

    def lattices(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.context.view_layer.objects if obj.type == "LATTICE"]

    def empties(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.context.view_layer.objects if obj.type == "EMPTY"]

    def users(self) -> list[bpy.types.Object]:
        return [obj for obj in self.meshes() if scenes.part("tool.stack").ours(obj)]

    def some_mesh(self) -> bpy.types.Object | None:
        return self._some([obj for obj in self.meshes() if obj.visible_get()])

    def some_user(self) -> bpy.types.Object | None:
        return self._some(self.users())

    def some_lattice(self) -> bpy.types.Object | None:
        return self._some(self.lattices())

    def some_modifier(self, user: bpy.types.Object) -> bpy.types.NodesModifier:
        return self.random.choice(scenes.part("tool.stack").ours(user))

    def _some(self, pool: list[Any]) -> Any:
        return self.random.choice(pool) if pool else None


def kept(obj: bpy.types.Object) -> tuple[float, float] | None:
    """The volume that must come out and how exactly; None where the modifier says that it did not correct, or where
    another one follows, so that what Blender shows is not what left ours."""
    modifiers = scenes.part("tool.stack").active(obj, "VIEWPORT")
    last = obj.modifiers[-1]
    if obj.mode != "OBJECT" or not obj.visible_get() or last not in modifiers:
        return None
    if not all(map(scenes.part("tool.stack").is_ours, modifiers)):
        return None
    if any(True for _loop in pieces.loops(pieces.triangles_of(obj.data))):
        return None
    memory = scenes.part("tool.state").recall(obj, last)
    if memory is None or not memory.report.keeps_volume or scenes.get_input(last, "Preserve") < 1.0:
        return None
    target = wanted(obj, modifiers, memory.report)
    reach = np.abs(scenes.evaluated_positions(obj) - memory.report.grid.to_object[:3, 3]).max()
    rounding = 4.0 * SINGLE * area(obj) * reach / abs(target)
    return target, max(TOLERANCE, rounding)


def wanted(obj: bpy.types.Object, modifiers: list[bpy.types.Modifier], report: Any) -> float:
    """From the mesh itself where that is what entered and counts; else what the modifier says that it aims at."""
    last = obj.modifiers[-1]
    own_shape = len(modifiers) == 1 and obj.data.shape_keys is None
    one_volume = report.volumes.bodies == 1 and not report.missing and not scenes.get_input(last, "Region")
    if own_shape and one_volume and scenes.get_input(last, "Reference") == "Incoming":
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers[last.name]
        return scenes.volume(obj.data) * float(scenes.get_input(evaluated, "Target"))
    return float(report.volumes.target - report.missing)


def area(obj: bpy.types.Object) -> float:
    """Of what Blender draws of the object."""
    mesh = scenes.evaluated_mesh(obj)
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    a, b, c = scenes.positions(mesh)[triangles.reshape(-1, 3)].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0
