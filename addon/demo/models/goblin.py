# SPDX-License-Identifier: GPL-3.0-or-later
"""The head of a goblin with large ears, on its neck (numpy only)."""

import numpy as np

from .distances import arc, chain, ellipsoid, joined, without
from .implicit import surface
from .model import Array, Model

SPACING = 0.0225
EAR = [(0.38, 0.1, 1.3), (0.66, 0.14, 1.56), (0.92, 0.12, 1.86), (1.12, 0.06, 2.2)]
"""The middle of the ear from the head to its tip, on the side of +x."""
EAR_RADII, HOLLOW_RADII = [0.15, 0.25, 0.18, 0.065], [0.05, 0.155, 0.085, 0.0]
PIECES = 24
"""Places along an ear."""
EAR_BACK, EAR_PINK_FROM = 0.17, 1.42
"""In y and z: behind and below that an ear is green outside and inside."""
EAR_THIN = 2.2
"""How much flatter than wide an ear is."""
BROW = [(0.06, -0.5, 1.2), (0.26, -0.47, 1.28), (0.46, -0.3, 1.3)]
SMILE = [(0.0, -0.83, 0.76), (0.14, -0.74, 0.75), (0.26, -0.58, 0.79), (0.34, -0.46, 0.87)]
NECK, NECK_BOTTOM = [(0.0, 0.16, 0.9), (0.0, 0.2, 0.5), (0.0, 0.2, -0.3)], 0.1
EYE, EYE_RADIUS = (0.245, -0.4, 1.1), 0.13
PUPIL = (0.235, -0.54, 1.1)
NOSE = (0.0, -0.84, 0.93)


def make_goblin() -> Model:
    """Stands on z = 0 with its neck, looks along -y. Values: eye, pupil, nose, inner ear, muzzle."""
    points, triangles = surface(_distance, (-1.3, -1.1, -0.1), (1.3, 0.8, 2.4), SPACING)
    mirrored = _mirrored(points)
    seen = np.maximum(_ear(mirrored, HOLLOW_RADII, thin=0.0), EAR_PINK_FROM - mirrored[:, 2])
    values = {
        "eye": _from(mirrored, EYE) - EYE_RADIUS - 0.006,
        "pupil": _from(mirrored, PUPIL) - 0.06,
        "nose": _from(mirrored, NOSE) - 0.1,
        "inner_ear": np.maximum(seen, mirrored[:, 1] - EAR_BACK),
        "muzzle": ellipsoid(points, (0.0, -0.62, 0.72), (0.36, 0.4, 0.26)),
    }
    points[:, 2] -= points[:, 2].min()
    return Model(points, triangles, values)


def off_ear(points: Array) -> Array:
    """Distance of points of the model from the middle of the ear on the side of +x."""
    places = [(x, y, z - NECK_BOTTOM) for x, y, z in arc(EAR, PIECES)]
    return chain(points, places, [0.0] * PIECES)


def _distance(points: Array) -> Array:
    """Mirrored in x, so that half of the parts are enough."""
    mirrored = _mirrored(points)
    head = joined(
        ellipsoid(mirrored, (0.0, 0.06, 1.06), (0.6, 0.58, 0.52)),
        ellipsoid(mirrored, (0.3, -0.24, 0.82), (0.27, 0.26, 0.22)),
        0.15,
    )
    head = joined(head, ellipsoid(mirrored, (0.0, -0.5, 0.84), (0.27, 0.34, 0.2)), 0.14)
    head = joined(head, chain(mirrored, BROW, [0.06, 0.075, 0.04]), 0.08)
    head = joined(head, chain(mirrored, NECK, [0.32, 0.26, 0.36]), 0.16)
    head = joined(head, _ear(mirrored, EAR_RADII), 0.1)
    head = without(head, _ear(mirrored + np.array([0.0, 0.085, 0.0]), HOLLOW_RADII), 0.06)
    head = without(head, chain(mirrored, SMILE, [0.026, 0.026, 0.024, 0.02]), 0.03)
    head = joined(head, _from(mirrored, EYE) - EYE_RADIUS, 0.02)
    head = joined(head, _from(mirrored, NOSE) - 0.085, 0.03)
    return np.maximum(head, NECK_BOTTOM - points[..., 2])


def _from(points: Array, place: tuple[float, float, float]) -> Array:
    found: Array = np.sqrt(((points - np.array(place)) ** 2).sum(axis=-1))
    return found


def _ear(points: Array, radii: list[float], thin: float = EAR_THIN) -> Array:
    """A flat, pointed ear; near its surface about the distance. ``thin``: how much flatter than wide."""
    middle = np.array(arc(EAR, PIECES))
    radius = np.array(arc([(value,) for value in radii], PIECES))[:, 0]
    way = middle[-1] - middle[0]
    along = np.clip((points - middle[0]) @ way, 0.0, way @ way)
    places = (middle - middle[0]) @ way
    off = points - np.stack([np.interp(along, places, column) for column in middle.T], axis=-1)
    off[..., 1] *= thin
    found: Array = (np.sqrt((off**2).sum(axis=-1)) - np.interp(along, places, radius)) / 1.4
    return found


def _mirrored(points: Array) -> Array:
    """All on the side of +x."""
    found = points.copy()
    found[..., 0] = np.abs(points[..., 0])
    return found
