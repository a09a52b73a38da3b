# SPDX-License-Identifier: GPL-3.0-or-later
"""Which modifiers of an object are ours, which are on, and what stands around them."""

import bpy

from . import node_group

FACES_UNTOUCHED_BY = frozenset(
    "ARMATURE CAST COLLISION CORRECTIVE_SMOOTH CURVE DATA_TRANSFER DISPLACE HOOK LAPLACIANDEFORM LAPLACIANSMOOTH"
    " LATTICE MESH_CACHE MESH_DEFORM MULTIRES NORMAL_EDIT SHRINKWRAP SIMPLE_DEFORM SMOOTH SOFT_BODY SUBSURF"
    " SURFACE_DEFORM UV_PROJECT UV_WARP VERTEX_WEIGHT_EDIT VERTEX_WEIGHT_MIX VERTEX_WEIGHT_PROXIMITY VOLUME_DISPLACE"
    " WARP WAVE WEIGHTED_NORMAL".split()
)
"""Modifiers after which the faces are those of the mesh, or, of the two that subdivide, follow from them and their
number. The faces that leave any other modifier may change from frame to frame."""


DEFORMED = ("MESH", "CURVE", "CURVES", "FONT", "POINTCLOUD")
"""Types of objects with points on which Blender allows a Geometry Nodes modifier. On surfaces, metaballs and lattices
it does not; Grease Pencil, which takes one, keeps its points in layers of their own."""

VIEWPORT_OF_RENDER = {"show_render": "show_viewport", "render_levels": "levels"}
"""Settings of a modifier for renders, and those for the viewport that stand in for them while measuring."""


def is_ours(modifier: bpy.types.Modifier) -> bool:
    """Whether this modifier is a Volume Lattice."""
    return modifier.type == "NODES" and node_group.is_ours(modifier.node_group)


def ours(obj: bpy.types.Object) -> list[bpy.types.NodesModifier]:
    """The object's Volume Lattice modifiers in stack order, also those that are switched off."""
    return [modifier for modifier in obj.modifiers if is_ours(modifier)]


def is_on(modifier: bpy.types.Modifier, mode: str) -> bool:
    """Whether Blender evaluates the modifier in this depsgraph mode (VIEWPORT or RENDER)."""
    if mode == "RENDER":
        return modifier.show_render
    editing = modifier.id_data.mode == "EDIT"
    return modifier.show_viewport and (modifier.show_in_editmode or not editing)


def active(obj: bpy.types.Object, mode: str) -> list[bpy.types.Modifier]:
    """All modifiers that are evaluated in this mode, ours and others, in stack order."""
    return [modifier for modifier in obj.modifiers if is_on(modifier, mode)]


def face_stamp(modifiers: list[bpy.types.Modifier]) -> tuple[int, ...] | None:
    """Names modifiers whose faces change only with the mesh, or None where there are others."""
    steady = all(is_ours(modifier) or modifier.type in FACES_UNTOUCHED_BY for modifier in modifiers)
    return tuple(modifier.persistent_uid for modifier in modifiers) if steady else None


def keeps_own_vertices(modifiers: list[bpy.types.Modifier], modifier: bpy.types.Modifier) -> bool:
    """Whether the vertices of the object's own mesh are the first of those that enter ``modifier``."""
    before = modifiers[: modifiers.index(modifier)]
    return all(is_ours(other) or other.type in FACES_UNTOUCHED_BY for other in before)


def following(modifiers: list[bpy.types.Modifier], modifier: bpy.types.Modifier) -> list[bpy.types.Modifier]:
    """Those after ``modifier`` that are not ours."""
    place = modifiers.index(modifier)
    return [other for other in modifiers[place + 1 :] if not is_ours(other)]


def preceding(modifiers: list[bpy.types.Modifier], modifier: bpy.types.Modifier) -> list[bpy.types.Modifier]:
    """Those before ``modifier`` that are not ours."""
    place = modifiers.index(modifier)
    return [other for other in modifiers[:place] if not is_ours(other)]


def move_behind(modifier: bpy.types.Modifier, other: bpy.types.Modifier) -> None:
    """Moves a modifier in the stack, right behind another one."""
    obj = modifier.id_data
    names = [found.name for found in obj.modifiers]
    here, there = names.index(modifier.name), names.index(other.name)
    obj.modifiers.move(here, there + 1 if here > there else there)


def differing_before(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> list[tuple[bpy.types.Modifier, str, str]]:
    """(modifier, viewport setting, render setting) wherever the two differ in a modifier before this one."""
    before = obj.modifiers[: list(obj.modifiers).index(modifier)]
    return [
        (other, viewport, render)
        for other in before
        for render, viewport in VIEWPORT_OF_RENDER.items()
        if hasattr(other, render) and getattr(other, render) != getattr(other, viewport)
    ]


def users(group_list: list[bpy.types.NodeTree]) -> list[bpy.types.Object]:
    """Every object of the file with a Volume Lattice modifier, in order of name."""
    if not group_list:
        return []
    return [obj for obj in bpy.data.objects if obj.type in DEFORMED and any(map(is_ours, obj.modifiers))]
