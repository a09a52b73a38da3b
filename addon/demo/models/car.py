# SPDX-License-Identifier: GPL-3.0-or-later
"""A small saloon car: one closed body with windows, lamps and wheel arches in it, and four wheels (numpy only)."""

import numpy as np
from rings import ring_triangles

from .distances import ellipsoid, joined, polygon, without
from .implicit import surface
from .model import Array, Model, Triangles

SPACING = 0.06
"""Of the body's grid."""
AXLES, WHEEL, HUB_HEIGHT, TRACK = (-1.28, 1.3), 0.335, 0.335, 0.72
"""Places along x, radius of a wheel, height of its middle and how far that is from the middle of the car."""
FRONT, REAR, HALF_WIDTH = -2.15, 2.12, 0.86
LOWER = [(-2.1, 0.3), (-2.15, 0.5), (-2.1, 0.7), (-1.9, 0.8), (-0.8, 0.93), (1.45, 0.98), (2.0, 0.95)]
LOWER += [(2.12, 0.8), (2.1, 0.36), (1.9, 0.25), (-1.9, 0.23)]
"""(x, z) of the side view up to the bonnet and the boot, drawn in by ROUND."""
CABIN = [(-0.98, 0.8), (-0.24, 1.33), (0.1, 1.4), (0.62, 1.38), (0.95, 1.3), (1.62, 0.86)]
ROUND = 0.05
SIDE_GLASS = [(-0.62, 0.99), (-0.17, 1.29), (0.12, 1.335), (0.6, 1.315), (0.88, 1.24), (1.24, 1.0)]
PILLAR = (0.3, 0.05)
"""Middle and half-width along x of what stands between the side windows."""
SCREEN, BACK_SCREEN = (-0.8, -0.3), (0.98, 1.46)
"""Along x: where the windscreen and the rear window are."""
SIDES = 32
TYRE = [(0.16, -0.08), (0.2, -0.1), (0.29, -0.115), (0.327, -0.1), (0.335, -0.06), (0.335, 0.06), (0.327, 0.1)]
TYRE += [(0.29, 0.115), (0.215, 0.1), (0.2, 0.075), (0.1, 0.06)]
"""(radius, place on the axle) of a wheel's section, from its inner to its outer side."""


def make_car() -> Model:
    """Stands on z = 0, its front towards -x, 4.3 long. Values: glass, lamp, tail, trim, tyre, rim, wheel."""
    points, triangles = surface(_body, (-2.4, -1.1, 0.05), (2.4, 1.1, 1.6), SPACING)
    parts = [(points, triangles, _colours(points))]
    for x in AXLES:
        for side in (-1.0, 1.0):
            parts.append(_wheel(x, side))
    count = np.cumsum([0, *(len(part[0]) for part in parts)])
    values = {name: np.concatenate([part[2].get(name, np.ones(len(part[0]))) for part in parts]) for name in _NAMES}
    faces = np.concatenate([part[1] + start for part, start in zip(parts, count)])
    return Model(np.concatenate([part[0] for part in parts]), np.ascontiguousarray(faces, dtype=np.int32), values)


_NAMES = ("glass", "lamp", "tail", "trim", "tyre", "rim", "wheel")


def _width(points: Array) -> Array:
    """Half the width: drawn in towards the roof, the ends and the sills."""
    x, z = points[..., 0], points[..., 2]
    roof = 0.3 * np.clip((z - 0.9) / 0.5, 0.0, 1.2)
    ends = 0.2 * np.clip((np.abs(x) - 1.2) / 0.95, 0.0, 1.0) ** 2
    sill = 0.08 * np.clip((0.5 - z) / 0.3, 0.0, 1.0) ** 2
    return HALF_WIDTH - roof - ends - sill


def _body(points: Array) -> Array:
    side = np.stack([points[..., 0], points[..., 2]], axis=-1)
    across = np.abs(points[..., 1])
    width = _width(points)
    lower = -joined(-(polygon(side, LOWER) - ROUND), width - across, 0.14)
    cabin = -joined(-(polygon(side, CABIN) - ROUND), width - across, 0.1)
    body = joined(lower, cabin, 0.07)
    for x in AXLES:
        arch = np.hypot(points[..., 0] - x, points[..., 2] - HUB_HEIGHT) - WHEEL - 0.065
        body = without(body, np.maximum(arch, 0.5 - across), 0.06)
        flare = np.abs(np.hypot(points[..., 0] - x, points[..., 2] - HUB_HEIGHT) - WHEEL - 0.1) - 0.03
        limits = across - width - 0.03, 0.5 - across, 0.27 - points[..., 2]
        body = joined(body, np.maximum.reduce([flare, *limits]), 0.05)
    mirror = np.stack([points[..., 0], across, points[..., 2]], axis=-1)
    return joined(body, ellipsoid(mirror, (-0.52, 0.9, 1.02), (0.09, 0.1, 0.07)), 0.05)


def _colours(points: Array) -> dict[str, Array]:
    x, y, z = points.T
    across = np.abs(y)
    side = np.stack([x, z], axis=-1)
    outside = polygon(side, SIDE_GLASS)
    pillar = np.maximum(outside, PILLAR[1] - np.abs(x - PILLAR[0]))
    by_the_side = np.maximum(pillar, _width(points) - 0.09 - across)
    narrow = across - _width(points) + 0.14
    screens = [np.maximum.reduce([low - x, x - high, narrow]) for low, high in (SCREEN, BACK_SCREEN)]
    above = np.interp(x, [FRONT, -0.8, 1.45, REAR], [0.95, 0.99, 1.03, 1.03]) - z
    lamps = ellipsoid(np.stack([x, across, z], axis=-1), (-2.1, 0.56, 0.66), (0.22, 0.17, 0.075))
    tail = np.maximum(np.maximum(1.98 - x, np.abs(z - 0.74) - 0.07), 0.38 - across)
    grille = np.maximum(np.maximum(x + 2.02, np.abs(z - 0.47) - 0.07), across - 0.5)
    trim = np.minimum(z - 0.29, grille)
    glass = np.maximum(np.minimum(by_the_side, np.minimum(*screens)), above)
    return {"glass": glass, "lamp": lamps, "tail": tail, "trim": trim}


def _wheel(x: float, side: float) -> tuple[Array, Triangles, dict[str, Array]]:
    """One wheel, its outer side towards ``side`` along y."""
    section = np.array(TYRE)
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    rings = [np.column_stack([radius * ring, np.full(SIDES, place)]) for radius, place in section]
    ends = [(0.0, 0.0, section[0, 1]), (0.0, 0.0, section[-1, 1] + 0.015)]
    made = np.concatenate([*rings, np.array(ends)])
    out = np.hypot(made[:, 0], made[:, 1])
    placed = np.column_stack([made[:, 0] + x, side * (TRACK + made[:, 2]), made[:, 1] + HUB_HEIGHT])
    triangles = ring_triangles(len(made), SIDES)
    values = {"tyre": -np.ones(len(made)), "rim": np.maximum(out - 0.208, 0.04 - out), "wheel": -np.ones(len(made))}
    # Turned upright the rings' own orientation is kept on one side and mirrored on the other.
    return placed, triangles[:, ::-1] if side > 0.0 else triangles, values
