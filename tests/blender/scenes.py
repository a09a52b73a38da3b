# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for the tests and benchmarks, and what they read back from Blender."""

import importlib
from types import ModuleType
from typing import Any

import bpy
import numpy as np
from installed_extension import MODULE
from numpy.typing import NDArray

MODIFIER = "Volume Lattice"


def part(name: str) -> ModuleType:
    """A module of the installed extension, such as "tool.sockets"."""
    return importlib.import_module(f"{MODULE}.{name}")


def empty_file() -> None:
    """A file with a scene and nothing in it."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def mesh_object(name: str, points: Any, faces: Any) -> bpy.types.Object:
    """A mesh object in the scene, active and selected alone."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, point)) for point in points], [], [tuple(map(int, face)) for face in faces])
    return linked(bpy.data.objects.new(name, mesh))


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    """Links the object to the scene and makes it the active and only selected one."""
    bpy.context.scene.collection.objects.link(obj)
    choose(obj)
    return obj


def choose(obj: bpy.types.Object) -> None:
    """Makes the object the active and only selected one."""
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj


def sphere(columns: int = 24, rows: int = 16, name: str = "Ball") -> bpy.types.Object:
    """A triangulated ball of radius 1 with a bump, so that it has no symmetry to hide an error in."""
    points, triangles = sphere_arrays(columns, rows)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.attributes["position"].data.foreach_set("vector", points.astype(np.float32).reshape(-1))
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.reshape(-1))
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    return linked(bpy.data.objects.new(name, mesh))


def sphere_arrays(columns: int, rows: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Points and outward triangles of the ball."""
    polar, around = np.meshgrid(
        np.pi * np.arange(1, rows + 1) / (rows + 1), 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    ring = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    points = np.concatenate([ring.reshape(-1, 3), [(0, 0, 1), (0, 0, -1)]])
    points *= 1.0 + 0.15 * np.exp(-4.0 * np.sum((points - (0.6, 0.64, 0.48)) ** 2, axis=1))[:, None]
    here = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    beside = np.roll(here, -1, axis=1)
    top, bottom = np.full(columns, rows * columns), np.full(columns, rows * columns + 1)
    parts = [
        np.stack([here[:-1], here[1:], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([here[:-1], beside[1:], beside[:-1]], axis=-1).reshape(-1, 3),
        np.stack([top, here[0], beside[0]], axis=-1),
        np.stack([bottom, beside[-1], here[-1]], axis=-1),
    ]
    return points, np.ascontiguousarray(np.concatenate(parts), dtype=np.int32)


def lattice_object(side: int | tuple[int, int, int] = 4, name: str = "Lattice", size: float = 2.6) -> bpy.types.Object:
    """A Blender lattice object in the scene, a cube of ``size`` about the origin."""
    lattice = bpy.data.objects.new(name, bpy.data.lattices.new(name))
    shape = (side, side, side) if isinstance(side, int) else side
    lattice.data.points_u, lattice.data.points_v, lattice.data.points_w = shape
    lattice.scale = (size, size, size)
    bpy.context.scene.collection.objects.link(lattice)
    return lattice


def squashing_lattice(around: bpy.types.Object, side: int, frames: int) -> bpy.types.Object:
    """A uniform cubic lattice whose domain holds the object, squashed and sheared by a shape key, keyed over frames."""
    size = 1.1 * max(around.dimensions) * (side - 1) / (side - 3)
    lattice = lattice_object(side, size=size)
    for kind in ("interpolation_type_u", "interpolation_type_v", "interpolation_type_w"):
        setattr(lattice.data, kind, "KEY_BSPLINE")
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash")
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.3 * z, y + 0.1 * x * z, 0.4 * z)
    for frame, value in ((1, 0.0), (frames // 2, 1.0), (frames, 0.2)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return lattice


def native_lattice(obj: bpy.types.Object, lattice: bpy.types.Object) -> bpy.types.LatticeModifier:
    """Blender's own Lattice modifier on the object."""
    modifier = obj.modifiers.new("Lattice", "LATTICE")
    modifier.object = lattice
    return modifier


def volume_lattice(obj: bpy.types.Object, lattice: bpy.types.Object | None, **inputs: Any) -> bpy.types.NodesModifier:
    """Our modifier on the object with an existing lattice, through isochor.add; its inputs by name (Vertex_Group)."""
    choose(obj)
    assert bpy.ops.isochor.add(resolution=(2, 2, 2)) == {"FINISHED"}
    modifier = obj.modifiers.active
    made = get_input(modifier, "Lattice")
    set_input(modifier, "Lattice", lattice)
    bpy.data.objects.remove(made)
    for name, value in inputs.items():
        set_input(modifier, name.replace("_", " "), value)
    bpy.context.view_layer.update()
    return modifier


def set_input(modifier: bpy.types.NodesModifier, name: str, value: Any) -> None:
    """Sets an input of our modifier by its name."""
    part("tool.sockets").write(modifier, name, value)


def get_input(modifier: bpy.types.NodesModifier, name: str) -> Any:
    """Value of an input of our modifier by its name."""
    return part("tool.sockets").read(modifier, name)


def report(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, mode: str = "VIEWPORT") -> Any:
    """What the sidebar would show of the modifier."""
    return part("tool.state").recall(obj, modifier, mode).report


def evaluated_mesh(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> bpy.types.Mesh:
    """The mesh that Blender draws or renders."""
    return obj.evaluated_get(depsgraph or bpy.context.evaluated_depsgraph_get()).data


def positions(mesh: bpy.types.Mesh) -> NDArray[np.float64]:
    """(V, 3) vertices."""
    found = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", found)
    return found.reshape(-1, 3).astype(np.float64)


def evaluated_positions(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> NDArray[np.float64]:
    """(V, 3) vertices that Blender draws or renders, in object space."""
    return positions(evaluated_mesh(obj, depsgraph))


def volume(mesh: bpy.types.Mesh) -> float:
    """Signed volume in float64 over the mesh's triangles."""
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    a, b, c = positions(mesh)[triangles.reshape(-1, 3)].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def evaluated_volume(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> float:
    """Signed volume of what Blender draws or renders."""
    return volume(evaluated_mesh(obj, depsgraph))
