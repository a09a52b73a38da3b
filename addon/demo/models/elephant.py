# SPDX-License-Identifier: GPL-3.0-or-later
"""A toy elephant of bicubic Bezier patches, closed and without seams: a cage of quads drawn out of a barrel."""

from math import cos, radians, sin

import numpy as np

from .model import Array, Model
from .patch_model import PatchModel
from .quad_cage import QuadCage
from .smooth_patches import smooth_patches

BELOW = ((-0.75, -0.92), (-0.3, -1.1), (0.3, -1.1), (0.75, -0.92))
ABOVE = ((0.78, 0.84), (0.3, 1.16), (-0.3, 1.16), (-0.78, 0.84))
RING = (*BELOW, (1.12, 0.0), *ABOVE, (-1.12, 0.0))
"""A section of the barrel, (y, z) in half widths, in turn as seen from the front."""
SECTIONS = (
    (-1.10, 1.30, 0.36, 0.38, -20.0),
    (-0.88, 1.30, 0.60, 0.60, -10.0),
    (-0.42, 1.36, 0.70, 0.68, -2.0),
    (0.04, 1.40, 0.70, 0.70, 4.0),
    (0.46, 1.52, 0.54, 0.56, 10.0),
    (0.64, 1.78, 0.46, 0.44, 12.0),
    (0.82, 1.90, 0.56, 0.54, 4.0),
    (1.26, 1.88, 0.46, 0.48, -14.0),
)
"""From rump to face: x, z, half width, half height, and how far the section leans forward at the top, in degrees."""
LEG_HEIGHTS = ((0.56, 0.25), (0.16, 0.235), (-0.014, 0.27))
"""(height, half width), from the body down: the patches end a little above the last, on the ground."""
LEGS = ((0, -0.74, 0.40), (3, 0.36, 0.38))
"""Segment of the barrel that it stands under, and its x and y."""
TRUNK = (
    ((1.60, 0.0, 1.62), (1.0, 0.0, -0.35), 0.20),
    ((1.90, 0.0, 1.34), (0.55, 0.0, -1.0), 0.175),
    ((2.02, 0.0, 0.96), (0.15, 0.0, -1.0), 0.15),
    ((2.10, 0.0, 0.64), (0.6, 0.0, -0.8), 0.135),
    ((2.32, 0.0, 0.52), (1.0, 0.0, 0.3), 0.125),
    ((2.52, 0.0, 0.68), (0.4, 0.0, 1.0), 0.125),
    ((2.58, 0.0, 0.92), (0.1, 0.0, 1.0), 0.10),
)
"""Middle, direction and half width."""
EAR = (
    ((0.68, 0.68, 1.92), (-0.45, 1.0, 0.0), 0.07, 0.38),
    ((0.58, 0.94, 1.88), (-0.50, 1.0, 0.0), 0.065, 0.66),
    ((0.44, 1.26, 1.80), (-0.60, 1.0, -0.1), 0.06, 0.66),
    ((0.34, 1.44, 1.72), (-0.60, 1.0, -0.1), 0.05, 0.44),
)
"""Middle, direction, half thickness and half height, of the left one."""
TAIL = (
    ((-1.34, 0.0, 1.42), (-1.0, 0.0, -0.3), 0.075),
    ((-1.50, 0.0, 1.14), (-0.3, 0.0, -1.0), 0.055),
    ((-1.54, 0.0, 0.84), (-0.1, 0.0, -1.0), 0.05),
    ((-1.56, 0.0, 0.68), (-0.1, 0.0, -1.0), 0.085),
    ((-1.57, 0.0, 0.52), (-0.1, 0.0, -1.0), 0.06),
)
EAR_SEGMENT = 5
EYE, EYE_RADIUS = (1.16, 0.455, 2.03), 0.075
"""Middle of the left one, which is only painted on."""
CLOTH = (-0.36, 0.40, 1.12)
"""Middle in x and half width of the saddle cloth, and the height at which it ends."""
INNER_EAR = (1.10, 1.82, 0.24, 0.46)
"""Middle (y, z) and half axes of the pale part of the left ear's front."""
CAP = ((0, 1, 10, 9), (1, 2, 11, 10), (2, 3, 4, 11), (9, 10, 7, 8), (10, 11, 6, 7), (11, 4, 5, 6))
"""Quads of an end: its ten corners in turn, then its two inner points."""


PUSHED = 0.1
"""How far the inner points of an end stand out."""


def make_elephant() -> PatchModel:
    """Stands on z = 0, looks along +x, symmetric in y."""
    cage = QuadCage()
    _barrel(cage)
    rump, face = (_end(cage, section) for section in (0, len(SECTIONS) - 1))
    for segment, x, y in LEGS:
        for column, sign in ((2, 1.0), (0, -1.0)):
            foot = [((x, sign * y, z), (0.0, 0.0, -1.0), half, half) for z, half in LEG_HEIGHTS]
            cage.draw_out(segment * len(RING) + column, foot)
    for column, sign in ((4, 1.0), (8, -1.0)):
        ear = [((x, sign * y, z), (dx, sign * dy, dz), tall, thin) for (x, y, z), (dx, dy, dz), thin, tall in EAR]
        cage.draw_out(EAR_SEGMENT * len(RING) + column, ear)
    cage.draw_out(face + 1, [(middle, looks, half, half) for middle, looks, half in TRUNK])
    cage.draw_out(rump + 4, [(middle, looks, half, half) for middle, looks, half in TAIL])
    return smooth_patches(cage)


def elephant_mesh(level: int) -> Model:
    """The elephant tessellated, with the values that colour it."""
    found = make_elephant().tessellate(level)
    return Model(found.vertices, found.triangles, paint(found.vertices))


def paint(points: Array) -> dict[str, Array]:
    """Signed distances of points of the elephant at rest to the edges of its colours: cloth, trim, ear, eye, tuft."""
    x, y, z = points[:, 0], np.abs(points[:, 1]), points[:, 2]
    cloth = np.maximum(np.abs(x - CLOTH[0]) - CLOTH[1], CLOTH[2] - z)
    eye = np.linalg.norm(np.stack([x, y, z], axis=1) - np.array(EYE), axis=1) - EYE_RADIUS
    middles = np.array([middle for middle, *_ in EAR])
    behind = np.interp(y, middles[:, 1], middles[:, 0]) - x
    oval = np.hypot((y - INNER_EAR[0]) / INNER_EAR[2], (z - INNER_EAR[1]) / INNER_EAR[3]) - 1.0
    ear = np.maximum(0.3 * oval, behind)
    tuft = np.maximum(x - TAIL[2][0][0] - 0.2, z - TAIL[2][0][2] + 0.08)
    return {"cloth": cloth, "trim": np.abs(cloth + 0.035) - 0.03, "ear": ear, "eye": eye, "tuft": tuft}


def _barrel(cage: QuadCage) -> None:
    """The sections and the quads between them, open at both ends."""
    for x, z, wide, high, lean in SECTIONS:
        across, up = sin(radians(lean)), cos(radians(lean))
        cage.add((x + high * c * across, wide * b, z + high * c * up) for b, c in RING)
    for first in range(0, len(RING) * (len(SECTIONS) - 1), len(RING)):
        for a in range(len(RING)):
            b = (a + 1) % len(RING)
            cage.quads.append((first + a, first + b, first + len(RING) + b, first + len(RING) + a))


def _end(cage: QuadCage, section: int) -> int:
    """Closes an end of the barrel; the number of its first quad."""
    x, z, wide, _, _ = SECTIONS[section]
    front = section > 0
    inner = cage.add((x + (PUSHED if front else -PUSHED), side * wide, z) for side in (-0.3, 0.3))
    names = [*range(section * len(RING), (section + 1) * len(RING)), *inner]
    first = len(cage.quads)
    for quad in CAP:
        corners = tuple(names[corner] for corner in quad)
        cage.quads.append(corners if front else corners[::-1])
    return first
