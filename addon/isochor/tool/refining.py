# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives a lattice object more points with the very same deformation, its shape keys and vertex groups too."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core import problem
from ..core.blending import Blending, pulls
from ..core.grid import Grid
from ..core.refining import Refinement, refinement, refuse_basis
from ..core.words import Sentence, listed
from . import (
    animated,
    baked_lattice,
    bound,
    control,
    converting,
    drivers,
    evaluated,
    lattice_keys,
    lattice_weights,
    lattices,
    results,
    sockets,
)

Array = NDArray[np.float64]
Shape = tuple[int, int, int]

ROUNDING = 1e-6
"""Change of the box, as a fraction of its size, that is none."""


@dataclass(frozen=True)
class Plan:
    """What is to be done to one lattice object."""

    lattice: bpy.types.Object
    refinement: Refinement
    warnings: list[str]

    @property
    def changes(self) -> bool:
        """Whether there are more points."""
        return self.refinement.before.shape != self.refinement.after.shape


def plan(lattice: bpy.types.Object, asked: Shape) -> Plan:
    """To so many points, 0 for the next finer lattice. Raises Problem where the shape would not stay."""
    sharing = [obj for obj in bpy.data.objects if obj.data == lattice.data]
    for obj in sharing:
        _refuse_object(obj)
    if lattice.data.is_editmode:
        raise problem.Problem(problem.resolution_in_edit_mode(lattice.name))
    control.refuse_if_locked(lattice)
    _refuse_data(lattice)
    points = evaluated.lattice_points(lattice)
    users = [user for obj in sharing for user in lattices.users_of(obj)]
    blending = _blending(lattice, users)
    refuse_basis(lattice.name, blending, points.shape)
    how = blending.basis, np.eye(4), blending.interpolation, blending.weights
    grid = Grid(points.shape, points.low, points.high, *how)
    made = Plan(lattice, refinement(lattice.name, grid, asked), _shaped_finer(users))
    if _box_changes(made.refinement):
        for obj in sharing:
            _refuse_box(obj)
    return made


def apply(made: Plan, context: bpy.types.Context) -> None:
    """Does it. Nothing that a modifier shapes changes."""
    lattice, fine = made.lattice, made.refinement
    if not made.changes:
        return
    points = control.read_own(lattice)[None]
    groups = [lattice_weights.flat(lattice, group) for group in lattice.vertex_groups]
    keys = lattice_keys.take(lattice)
    lattice.data.points_u, lattice.data.points_v, lattice.data.points_w = fine.after.shape
    to_new = _fit(lattice, fine)
    control.resize(lattice, (fine.points(points) * to_new)[0], fine.after.shape)
    found = fine.groups(np.array(groups)) if groups else np.empty((0, 0))
    for group, weights in zip(lattice.vertex_groups, found, strict=True):
        lattice_weights.assign(group, weights)
    if keys is not None:
        lattice_keys.put_back(lattice, keys, fine.points(keys.points) * to_new)
    lattice.data.update_tag()
    context.view_layer.update()


def _refuse_object(lattice: bpy.types.Object) -> None:
    """Of one object that shares the points, and those that it shapes."""
    if not lattice.is_editable:
        raise problem.Problem(problem.foreign(lattice.name))
    if baked_lattice.is_baked(lattice):
        raise problem.Problem(problem.simulated(lattice.name))
    modifiers = [found.name for found in lattice.modifiers if found.show_viewport or found.show_render]
    if modifiers:
        raise problem.Problem(
            Sentence(
                "“{name}” has modifiers ({modifiers}), such as hooks, that hold single points: remove them, or apply"
                " them as shape keys, before there are others.",
                name=lattice.name,
                modifiers=", ".join(modifiers),
            )
        )
    users = [user.name for user, modifier in lattices.users_of(lattice) if _is_bound(modifier)]
    if users:
        raise problem.Problem(problem.bound_to(lattice.name, users))
    native = [obj.name for obj in converting.users_of(lattice)]
    if native:
        raise problem.Problem(
            Sentence(
                "Blender's own Lattice modifier deforms {names} by “{name}”: convert that first.",
                names=listed(native),
                name=lattice.name,
            )
        )


def _is_bound(modifier: bpy.types.NodesModifier) -> bool:
    return bool(bound.bound_with(results.of(modifier, "VIEWPORT")))


def _refuse_data(lattice: bpy.types.Object) -> None:
    data = lattice.data
    moving = [path for path in animated.paths(data) if path.startswith(("points", "interpolation", "use_outside"))]
    if moving:
        raise problem.Problem(
            Sentence(
                "Points of “{name}” are animated one by one ({paths}), which others cannot take over: turn that into"
                " shape keys first.",
                name=lattice.name,
                paths=", ".join(moving[:3]),
            )
        )
    if data.use_outside:
        raise problem.Problem(
            Sentence(
                "“{name}” has Outside on, with which Blender sets its inner points by itself: turn that off first.",
                name=lattice.name,
            )
        )
    lattice_keys.refuse(lattice)


def _blending(lattice: bpy.types.Object, users: list[lattices.Pair]) -> Blending:
    """How the points blend for all that the lattice shapes."""
    found = dict.fromkeys(
        tuple(sockets.read(modifier, name) for name in ("Basis", sockets.WEIGHTS, sockets.HEAVIEST))
        for _, modifier in users
    )
    if not users:
        raise problem.Problem(
            Sentence("“{name}” shapes nothing: pick it in a Volume Lattice first.", name=lattice.name)
        )
    chosen = {(basis, name, heaviest if name else 0.0) for basis, name, heaviest in found}
    if len(chosen) > 1:
        raise problem.Problem(
            Sentence(
                "{names} take the points of “{name}” by different Basis or Weights, so more points cannot suit all:"
                " give each a lattice of its own.",
                names=listed(obj.name for obj, _ in users),
                name=lattice.name,
            )
        )
    basis, name, heaviest = next(iter(found))
    weights = lattice_weights.of_group(lattice, name) if name else None
    if any(_moves(*user, ("Basis", sockets.HEAVIEST) if name else ("Basis",)) for user in users):
        raise problem.Problem(
            Sentence(
                "Basis or Heaviest is animated, so more points would deform otherwise in other frames: give them one"
                " value."
            )
        )
    types = evaluated.interpolation(lattice) if basis == "Blender" else None
    return Blending(basis, types, None if weights is None else pulls(weights, heaviest))


def _moves(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, names: tuple[str, ...]) -> bool:
    """Whether one of these inputs is animated."""
    return bool({drivers.data_path(modifier, name) for name in names} & set(animated.paths(obj)))


def _shaped_finer(users: list[lattices.Pair]) -> list[str]:
    """Warnings about users whose points are turned by numbers, which finer points follow more closely."""
    names = sockets.TAPER, sockets.TWIST, sockets.BEND
    turned = [
        obj.name
        for obj, modifier in users
        if any(sockets.read(modifier, name) for name in names) or _moves(obj, modifier, names)
    ]
    if not turned:
        return []
    return [
        Sentence(
            "{names}: Taper, Twist and Bend turn the points themselves, and more of them follow more closely, so the"
            " shape is not quite the same",
            names=listed(dict.fromkeys(turned)),
        )
    ]


def _box_changes(fine: Refinement) -> bool:
    ends = (fine.before.low, fine.before.high), (fine.after.low, fine.after.high)
    return bool(np.abs(np.subtract(*ends)).max() > ROUNDING)


def _refuse_box(lattice: bpy.types.Object) -> None:
    """Where the object cannot get another size on the same place."""
    constraints = [found.name for found in lattice.constraints if found.enabled and found.influence > 0.0]
    if constraints:
        raise problem.Problem(problem.constrained(lattice.name, constraints))
    moving = set(animated.paths(lattice))
    if {"scale", "delta_scale"} <= moving:
        raise problem.Problem(
            Sentence(
                "The scale of “{name}” is animated twice, as Scale and as Delta Scale, and its box must change: clear"
                " one of them.",
                name=lattice.name,
            )
        )
    odd = [child.name for child in lattice.children if child.parent_type != "OBJECT"]
    if odd:
        raise problem.Problem(
            Sentence(
                "{names} hang on single points of “{name}”: unparent them first.", names=listed(odd), name=lattice.name
            )
        )


def _fit(lattice: bpy.types.Object, fine: Refinement) -> Array:
    """Gives the objects that share the points the size of the new box, about the same middle; (3,) factors from the
    space of the points as they were into that of the new ones."""
    points = evaluated.lattice_points(lattice)
    now, wanted = np.array(points.box), np.array((fine.after.low, fine.after.high))
    sizes = [np.where(ends[1] > ends[0], ends[1] - ends[0], 1.0) for ends in (now, wanted)]
    scale = np.where(np.abs(sizes[1] / sizes[0] - 1.0) > ROUNDING, sizes[1] / sizes[0], 1.0)
    if np.any(scale != 1.0):
        for obj in [found for found in bpy.data.objects if found.data == lattice.data]:
            _resize(obj, scale)
    return np.asarray(1.0 / scale)


def _resize(obj: bpy.types.Object, scale: Array) -> None:
    """Changes the object's size, whether its scale is animated or not, with its children where they are."""
    moving = animated.paths(obj)
    name = "delta_scale" if "scale" in moving else "scale"
    setattr(obj, name, [one * other for one, other in zip(getattr(obj, name), scale, strict=True)])
    back = Matrix.Diagonal((*(1.0 / scale), 1.0))
    for child in obj.children:
        child.matrix_parent_inverse = back @ child.matrix_parent_inverse
