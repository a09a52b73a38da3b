# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of a lattice while its number of points changes, which Blender allows only where there are none: taken
off with all that is set and animated on them, and put back on other points."""

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.words import Sentence
from . import animation_paths

Points = NDArray[np.floating[Any]]

KEPT = ("value", "slider_min", "slider_max", "mute", "interpolation", "lock_shape")
"""Of each key, besides name, shape, place in time and what it is relative to. The limits go first when put back."""
PLAYED = ("action_blend_type", "action_extrapolation", "action_influence")


@dataclass
class Keys:
    """What was taken off. ``points``: (keys, points, 3), u fastest; ``readers``: targets of others' drivers."""

    points: Points = field(repr=False)
    blocks: list[dict[str, Any]]
    relative: bool
    eval_time: float
    readers: list[bpy.types.DriverTarget]
    spare: bpy.types.Lattice
    active: dict[str, int]


def refuse(lattice: bpy.types.Object) -> None:
    """Raises Problem where the keys could not be put back as they were."""
    keys = lattice.data.shape_keys
    if keys is None:
        return
    masked = [block.name for block in keys.key_blocks if block.vertex_group]
    if masked:
        raise problem.Problem(
            Sentence(
                "The shape keys {keys} of “{name}” act through a vertex group, which more points would blend otherwise:"
                " clear their Vertex Group first.",
                keys=", ".join(masked),
                name=lattice.name,
            )
        )
    if not keys.use_relative and keys.reference_key.frame != 0.0:
        raise problem.Problem(
            Sentence(
                "The first shape key of “{name}” is not at time 0, where Blender puts it when others are put back: use"
                " Re-Time Shape Keys first.",
                name=lattice.name,
            )
        )
    if keys.animation_data is not None and len(keys.animation_data.nla_tracks):
        raise problem.Problem(
            Sentence(
                "The shape keys of “{name}” are played by the NLA, which Blender does not let others put back: bake"
                " that into an action first.",
                name=lattice.name,
            )
        )


def take(lattice: bpy.types.Object) -> Keys | None:
    """Takes the keys off; None where there are none."""
    data = lattice.data
    keys = data.shape_keys
    if keys is None:
        return None
    blocks = [_settings(keys, block) for block in keys.key_blocks]
    shapes = np.array([_shape(block) for block in keys.key_blocks])
    active = {obj.name: obj.active_shape_key_index for obj in bpy.data.objects if obj.data == data}
    readers = animation_paths.targets_of(keys)
    found = Keys(shapes, blocks, keys.use_relative, keys.eval_time, readers, data.copy(), active)
    lattice.shape_key_clear()
    return found


def put_back(lattice: bpy.types.Object, taken: Keys, points: Points) -> None:
    """Puts the keys on the lattice, which has none, with these shapes (keys, points, 3)."""
    for settings, shape in zip(taken.blocks, points, strict=True):
        keys = lattice.data.shape_keys
        if keys is not None and not taken.relative:
            # A key of an absolute set stands at the time at which it is added.
            keys.use_relative, keys.eval_time = False, settings["frame"]
        block = lattice.shape_key_add(name=settings["name"], from_mix=False)
        block.points.foreach_set("co", np.ascontiguousarray(shape, np.float32).reshape(-1))
    keys = lattice.data.shape_keys
    keys.use_relative, keys.eval_time = taken.relative, taken.eval_time
    for block, settings in zip(keys.key_blocks, taken.blocks, strict=True):
        block.relative_key = keys.key_blocks[settings["relative"]]
        for name in sorted(KEPT, key=lambda name: not name.startswith("slider")):
            setattr(block, name, settings[name])
    _animate(keys, taken)
    for obj in bpy.data.objects:
        if obj.name in taken.active and obj.data == lattice.data:
            obj.active_shape_key_index = taken.active[obj.name]
    bpy.data.lattices.remove(taken.spare)


def _settings(keys: bpy.types.Key, block: bpy.types.ShapeKey) -> dict[str, Any]:
    found = {name: getattr(block, name) for name in KEPT}
    relative = [one.name for one in keys.key_blocks].index(block.relative_key.name)
    return {**found, "name": block.name, "frame": block.frame, "relative": relative}


def _shape(block: bpy.types.ShapeKey) -> Points:
    found = np.empty(len(block.points) * 3, np.float32)
    block.points.foreach_get("co", found)
    return found.reshape(-1, 3)


def _animate(keys: bpy.types.Key, taken: Keys) -> None:
    """Gives the keys the action and the drivers that they had, and those who read them the new ones."""
    old = taken.spare.shape_keys
    animation = old.animation_data
    for target in taken.readers:
        target.id = keys
    if animation is None:
        return
    new = keys.animation_data_create()
    new.action = animation.action
    if animation.action is not None:
        new.action_slot = animation.action_slot
    for name in PLAYED:
        setattr(new, name, getattr(animation, name))
    for curve in animation.drivers:
        copied = new.drivers.from_existing(src_driver=curve)
        for target in (target for variable in copied.driver.variables for target in variable.targets):
            if target.id == old:
                target.id = keys
