# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice as an elastic body in world space: what it is made of, what it carries, how it starts."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

import isochor

from .grid import Grid, build_lattice
from .request import Request
from .settings import Settings
from .solver import OUTSIDES

Array = NDArray[np.float64]
Triangles = NDArray[np.int32]

MOST_VERTICES, MOST_WEIGHTS = 2000, 4_000_000
"""Vertices of the surface that meet the ground and enclose the volume, and those times the points acting on each."""

FINEST = 48
"""Cells along each side of the surface's box where its vertices are thinned out, at most."""


@dataclass(frozen=True)
class Options:
    """What the animator set. Metres, seconds, radians; ``ground`` is a point of its plane and its normal, or None."""

    frequency: float
    damping: float
    friction: float
    gravity: tuple[float, float, float]
    ground: tuple[Array, Array] | None
    velocity: tuple[float, float, float]
    spin: tuple[float, float, float]
    substeps: int


@dataclass(frozen=True)
class Skin:
    """The surface that a lattice carries, in world space where the lattice is at rest: (V, 3), (F, 3) or None where no
    volume is to be kept, (V,) influence; ``volume`` is the factor of its own volume that is to be kept."""

    vertices: Array = field(repr=False)
    triangles: Triangles | None = field(repr=False)
    influence: Array = field(repr=False)
    volume: float = 1.0


def skin_of(request: Request, grid: Grid, volume: float | None) -> Skin:
    """The mesh that was bound in ``request``, carried by the lattice ``grid`` in world space. ``volume``: the factor of
    its own volume to keep, or None for none."""
    to_world = grid.to_object @ np.linalg.inv(request.embedding_grid.to_object)
    vertices = request.positions.astype(np.float64) @ to_world[:3, :3].T + to_world[:3, 3]
    influence = np.ones(len(vertices)) if request.influence is None else request.influence.astype(np.float64)
    triangles = None if volume is None else request.triangles
    return Skin(vertices, triangles, influence, 1.0 if volume is None else volume)


def joined(skins: list[Skin]) -> Skin:
    """All surfaces as one; no volume is kept where one of them has none."""
    if len(skins) == 1:
        return skins[0]
    offsets = np.cumsum([0, *(len(skin.vertices) for skin in skins)])
    parts = [
        skin.triangles + offset for skin, offset in zip(skins, offsets[:-1], strict=True) if skin.triangles is not None
    ]
    return Skin(
        np.concatenate([skin.vertices for skin in skins]),
        np.concatenate(parts).astype(np.int32) if len(parts) == len(skins) else None,
        np.concatenate([skin.influence for skin in skins]),
        float(np.mean([skin.volume for skin in skins])),
    )


def thinned(skin: Skin, most: int) -> Skin:
    """A surface of about ``most`` vertices: those in one cell of a grid become the one that stands furthest out
    (vertex clustering, Rossignac and Borrel 1993). What was closed stays closed."""
    for side in range(FINEST, 1, -4):
        if len(skin.vertices) <= most:
            break
        kept, home = clusters(skin.vertices, side)
        if len(kept) <= most or side <= 4:
            triangles = skin.triangles if skin.triangles is None else without_slivers(home[skin.triangles])
            return replace(skin, vertices=skin.vertices[kept], influence=skin.influence[kept], triangles=triangles)
    return skin


def clusters(vertices: Array, side: int) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """Index of the vertex that stands for each cell, and for each vertex the number of its cell among those."""
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0).max() or 1.0
    cells = np.minimum(((vertices - low) * (side / size)).astype(np.int64), side - 1)
    numbers, home = np.unique(cells @ np.array([side * side, side, 1]), return_inverse=True)
    distance = np.linalg.norm(vertices - (low + vertices.max(axis=0)) / 2.0, axis=1)
    order = np.lexsort((np.arange(len(vertices)), -distance, home))
    first = np.searchsorted(home[order], np.arange(len(numbers)))
    return order[first], home.astype(np.int32).reshape(-1)


def without_slivers(triangles: Triangles) -> Triangles:
    """Those with three different vertices."""
    a, b, c = triangles.T
    return np.ascontiguousarray(triangles[(a != b) & (b != c) & (c != a)])


def body(
    grid: Grid,
    skin: Skin,
    control: Array,
    velocity: Array,
    pinned: NDArray[np.bool_],
    settings: Settings,
    options: Options,
) -> isochor.Elastic:
    """The elastic body of a lattice in world space. A surface that is not closed is carried without its volume."""
    lattice = build_lattice(grid)
    taps = int(np.prod([degree + 1 for degree in lattice.degree]))
    skin = thinned(skin, max(64, min(MOST_VERTICES, MOST_WEIGHTS // taps)))

    def made(triangles: Triangles | None) -> isochor.Elastic:
        return isochor.Elastic(
            lattice,
            skin.vertices,
            triangles,
            control=control,
            velocity=velocity + thrown(control, options),
            pinned=pinned,
            frequency=options.frequency,
            damping=options.damping,
            gravity=options.gravity,
            ground=None if options.ground is None else np.stack(options.ground),
            friction=options.friction,
            volume=skin.volume,
            influence=skin.influence,
            outside=OUTSIDES[settings.outside],
            substeps=options.substeps,
        )

    try:
        return made(skin.triangles)
    except isochor.MeshError:
        return made(None)


def thrown(control: Array, options: Options) -> Array:
    """Velocities (nu, nv, nw, 3) of a throw with a spin about the middle of the control points."""
    away = control - control.reshape(-1, 3).mean(axis=0)
    return np.asarray(np.array(options.velocity) + np.cross(np.array(options.spin), away), np.float64)


def in_blender(control: Array, matrix: Array) -> NDArray[np.float32]:
    """World control points (nu, nv, nw, 3) as a Blender lattice of that matrix stores them: flat, u fastest."""
    inverse = np.linalg.inv(matrix)
    local = control @ inverse[:3, :3].T + inverse[:3, 3]
    return np.ascontiguousarray(local.transpose(2, 1, 0, 3), np.float32).reshape(-1)
