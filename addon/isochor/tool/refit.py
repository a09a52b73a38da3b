# SPDX-License-Identifier: GPL-3.0-or-later
"""Moving an existing lattice object to where its meshes are now, with what the animator made of its points."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core import problem
from . import (
    animated,
    baked,
    baked_lattice,
    bound,
    chain,
    control,
    evaluated,
    own_points,
    rest,
    results,
    sockets,
    state,
)

Array = NDArray[np.float64]
User = tuple[bpy.types.Object, bpy.types.NodesModifier]

TRANSFORM = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
TRANSFORMS = (*TRANSFORM, *(f"delta_{name}" for name in TRANSFORM))
ROUNDING = 1e-4
"""Part of the lattice's size by which Blender may miss the place that it is told to put it."""


def refuse(lattice: bpy.types.Object, users: list[User]) -> None:
    """Raises ``Problem`` where the lattice cannot be moved, or the volume of a user not be measured again."""
    for obj in (lattice, *(user for user, _ in users)):
        if not obj.is_editable:
            raise problem.Problem(problem.foreign(obj.name))
    if baked_lattice.is_baked(lattice):
        raise problem.Problem(problem.simulated(lattice.name))
    for user, _modifier in users:
        if baked.is_playing(user):
            raise problem.Problem(problem.plays_bake(user.name))
    bound_ones = [user.name for user, modifier in users if bound.bound_with(results.of(modifier, "VIEWPORT"))]
    if bound_ones:
        raise problem.Problem(problem.bound_to(lattice.name, bound_ones))
    constraints = [found.name for found in lattice.constraints if found.enabled and found.influence > 0.0]
    if constraints:
        raise problem.Problem(problem.constrained(lattice.name, constraints))
    moving = [path for path in animated.paths(lattice) if path in TRANSFORMS]
    if moving:
        raise problem.Problem(problem.animated_transform(lattice.name, moving))
    held = [found.name for found in lattice.modifiers if found.show_viewport or found.show_render]
    if held:
        raise problem.Problem(problem.held_points(lattice.name, held))


def refuse_resolution(lattice: bpy.types.Object, users: list[User], shape: tuple[int, int, int]) -> None:
    """Raises ``Problem`` where the lattice cannot get this many points without another deformation."""
    present = control.shape(lattice)
    if shape == present:
        return
    control.refuse_if_locked(lattice)
    if lattice.data.is_editmode:
        raise problem.Problem(problem.resolution_in_edit_mode(lattice.name))
    if lattice.data.shape_keys is not None:
        raise problem.Problem(problem.resolution_with_shape_keys(lattice.name))
    if basis(users) != "BERNSTEIN":
        raise problem.Problem(problem.resolution_of_splines(lattice.name))
    if any(new < old for new, old in zip(shape, present, strict=True)):
        raise problem.Problem(problem.resolution_lower(lattice.name, present))


def world_points(users: list[User], context: bpy.types.Context) -> Array:
    """(V, 3) what enters the users' modifiers, all together, in world space. Raises ``Problem`` where that is no
    place for a lattice."""
    parts = []
    for obj, modifier in users:
        matrix = np.array(obj.matrix_world, np.float64)
        parts.append(_entered(obj, modifier, context) @ matrix[:3, :3].T + matrix[:3, 3])
    points = np.concatenate(parts)
    if not len(points):
        raise problem.Problem(problem.NO_POINTS)
    if not np.isfinite(points).all():
        raise problem.Problem(problem.NO_PLACE)
    return points


def grid_scale(lattice: bpy.types.Object, users: list[User]) -> Array:
    """(3,) what makes the undeformed grid the unit cube: 1 unless a script made a larger one."""
    grids = [memory.report.grid for user in users if (memory := state.recall(*user)) is not None]
    known = next(((grid.low, grid.high) for grid in grids if grid is not None), evaluated.UNIT_BOX)
    low, high = known if lattice.data.is_editmode else evaluated.lattice_points(lattice).box
    size = np.subtract(high, low)
    return 1.0 / np.where(size > 0.0, size, 1.0)


def move(places: list[tuple[bpy.types.Object, Array]], context: bpy.types.Context) -> None:
    """Puts each object where its matrix (to world) says. Raises ``Problem``, with all of them as before, where a
    parent does not let one stand so."""
    before = [(lattice, lattice.matrix_basis.copy()) for lattice, _ in places]
    for lattice, matrix in places:
        lattice.matrix_world = Matrix(matrix.tolist())
    context.view_layer.update()
    for lattice, matrix in places:
        missed = np.abs(np.array(lattice.matrix_world) - matrix)[:3].max()
        if missed > ROUNDING * np.abs(matrix[:3]).max():
            for moved, basis_before in before:
                moved.matrix_basis = basis_before
            context.view_layer.update()
            raise problem.Problem(problem.skewed_by_parent(lattice.name))


def measure_again(users: list[User], context: bpy.types.Context) -> None:
    """Makes the volumes that enter now the rest volumes of whole chains; of what is not evaluated, as soon as it is."""
    users = chain.whole_of_all(users)
    for obj, modifier in users:
        for mode in results.INPUT_OF_MODE:
            result = results.of(modifier, mode)
            if result is not None and result.is_editable:
                results.forget_rest(result)
        obj.update_tag(refresh={"DATA"})
    context.view_layer.update()
    for obj, modifier in users:
        if obj.mode == "OBJECT" and obj.name in context.view_layer.objects:
            rest.measure_for_render(obj, modifier, context.view_layer)


def basis(users: list[User]) -> str:
    """The basis whose box holds the meshes of all users, as isochor.add names it."""
    return "BSPLINE" if any(sockets.read(modifier, "Basis") == "B-Spline" for _, modifier in users) else "BERNSTEIN"


def _entered(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, context: bpy.types.Context) -> Array:
    """(V, 3) in object space: what the modifier was given last; of what is edited or not evaluated, the own mesh."""
    if obj.type == "MESH" and obj.data.is_editmode:
        vertices = bmesh.from_edit_mesh(obj.data).verts
        return np.array([tuple(vertex.co) for vertex in vertices], np.float64).reshape(-1, 3)
    memory = state.recall(obj, modifier)
    if memory is None or memory.report.binding is None or obj.name not in context.view_layer.objects:
        return own_points.own(obj)
    entered = memory.solver.entered
    return own_points.own(obj) if entered is None else entered.astype(np.float64)
