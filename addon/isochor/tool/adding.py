# SPDX-License-Identifier: GPL-3.0-or-later
"""Making a Volume Lattice: the lattice object, the modifier, its first evaluation."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core.words import named
from . import handing, node_group, own_points, rest, results, sockets, state

MADE_BY_ADD = "isochor_made"
"""Custom property of a lattice object that isochor.add made, so that isochor.remove may take it away."""

BASIS_NAMES = {"BERNSTEIN": "Bernstein", "BSPLINE": "B-Spline"}


def world_points(obj: bpy.types.Object, context: bpy.types.Context) -> NDArray[np.float64]:
    """(V, 3) points in world space: as evaluated now, or in Edit Mode the selected ones (all where none is)."""
    matrix = np.array(obj.matrix_world, dtype=np.float64)
    points = _selected_positions(obj) if obj.mode == "EDIT" else np.empty((0, 3))
    if obj.mode != "EDIT" or (obj.type != "MESH" and not len(points)):
        points = own_points.shown(obj.evaluated_get(context.evaluated_depsgraph_get()))
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def new_lattice(
    name: str,
    shape: tuple[int, int, int],
    matrix: NDArray[np.float64],
    context: bpy.types.Context,
    beside: bpy.types.Object | None = None,
) -> bpy.types.Object:
    """A lattice object whose unit cube stands as ``matrix`` (to world) says, in the active collection; where that is
    hidden or from another file in one of those that ``beside`` is in."""
    data = bpy.data.lattices.new(name)
    lattice = bpy.data.objects.new(name, data)
    # Only now that an object has it does Blender keep the lattice's size when the resolution changes.
    data.points_u, data.points_v, data.points_w = shape
    lattice.matrix_world = Matrix(matrix.tolist())
    lattice[MADE_BY_ADD] = True
    open_collection(context, beside).objects.link(lattice)
    space = context.space_data
    if space is not None and space.type == "VIEW_3D" and space.local_view is not None:
        lattice.local_view_set(space, True)
    return lattice


def open_collection(context: bpy.types.Context, beside: bpy.types.Object | None) -> bpy.types.Collection:
    """A collection whose objects show and can be changed: the active one, one around ``beside``, or the scene's."""
    layers = _layers(context.view_layer.layer_collection)
    around = [] if beside is None else [layer for layer in layers if beside.name in layer.collection.objects]
    for layer in (context.view_layer.active_layer_collection, *around):
        if layer.is_visible and not layer.hide_viewport and takes_objects(layer.collection):
            return layer.collection
    return context.scene.collection


def takes_objects(collection: bpy.types.Collection) -> bool:
    """Whether objects can be linked to it: not where it is another file's, or overrides one of another file."""
    return bool(collection.is_editable and collection.override_library is None)


def _layers(layer: bpy.types.LayerCollection) -> list[bpy.types.LayerCollection]:
    """A layer collection and all below it."""
    return [layer, *(found for child in layer.children for found in _layers(child))]


def make_child(lattice: bpy.types.Object, obj: bpy.types.Object) -> None:
    """Has the lattice move along with the object, from where it stands."""
    lattice.parent = obj
    lattice.matrix_parent_inverse = obj.matrix_world.inverted_safe()


def lock_interface(scene: bpy.types.Scene) -> bool:
    """Has Blender lock its interface during renders, so that nobody edits what handlers write; whether it was off."""
    was_off = not scene.render.use_lock_interface
    scene.render.use_lock_interface = True
    return was_off


def add_modifiers(
    objects: list[bpy.types.Object],
    lattice: bpy.types.Object,
    basis: str,
    context: bpy.types.Context,
    only_last: bool = False,
) -> list[str]:
    """Gives each object the modifier, which with ``only_last`` corrects in place of one right before it, computes it
    once and keeps its rest volume; returns problems in plain words."""
    added = [(obj, _add_modifier(obj, lattice, basis)) for obj in objects]
    for obj, modifier in added if only_last else []:
        handing.to_last(obj, modifier)
    results.ensure_own()
    context.view_layer.update()
    for obj, modifier in added:
        rest.measure_for_render(obj, modifier, context.view_layer)
    memories = [(obj, state.recall(obj, modifier)) for obj, modifier in added]
    return [named(obj.name, text) for obj, memory in memories if memory is not None for text in memory.report.problems]


def _add_modifier(obj: bpy.types.Object, lattice: bpy.types.Object, basis: str) -> bpy.types.NodesModifier:
    modifier = obj.modifiers.new(node_group.NAME, "NODES")
    modifier.node_group = node_group.ensure()
    modifier.show_group_selector = False
    sockets.write(modifier, sockets.LATTICE, lattice)
    sockets.write(modifier, "Basis", BASIS_NAMES[basis])
    obj.modifiers.active = modifier
    return modifier


def _selected_positions(obj: bpy.types.Object) -> NDArray[np.float64]:
    """Of a mesh in Edit Mode, whose attributes Blender does not show; all vertices where none is selected."""
    if obj.type != "MESH":
        return own_points.selected(obj)
    vertices = bmesh.from_edit_mesh(obj.data).verts
    chosen = [vertex.co for vertex in vertices if vertex.select] or [vertex.co for vertex in vertices]
    return np.array([tuple(point) for point in chosen], np.float64).reshape(-1, 3)
