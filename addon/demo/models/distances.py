# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distances of simple bodies and how they join smoothly (numpy only)."""

import numpy as np

from .model import Array

Place = tuple[float, ...]


def ellipsoid(points: Array, centre: Place, radii: Place) -> Array:
    """Near the surface the distance to an ellipsoid along the axes."""
    scaled = (points - np.array(centre)) / np.array(radii)
    length = np.sqrt((scaled**2).sum(axis=-1))
    slope = np.sqrt(((scaled / np.array(radii)) ** 2).sum(axis=-1))
    distance: Array = length * (length - 1.0) / np.maximum(slope, 1e-9)
    return distance


def chain(points: Array, places: list[Place], radii: list[float]) -> Array:
    """To a chain of round cones: places in two or three dimensions, each with its radius."""
    nearest = np.full(points.shape[:-1], np.inf)
    for start, end, near, far in zip(places, places[1:], radii, radii[1:]):
        way = np.array(end) - np.array(start)
        along = np.clip((points - np.array(start)) @ way / (way @ way), 0.0, 1.0)
        off = points - np.array(start) - along[..., None] * way
        nearest = np.minimum(nearest, np.sqrt((off**2).sum(axis=-1)) - (near + along * (far - near)))
    return nearest


def polygon(points: Array, corners: list[Place]) -> Array:
    """In the plane, to a polygon given by its corners in order."""
    ring = np.array(corners)
    nearest, inside = np.full(points.shape[:-1], np.inf), np.zeros(points.shape[:-1], dtype=bool)
    for start, end in zip(ring, np.roll(ring, -1, axis=0)):
        way, off = end - start, points - start
        along = np.clip(off @ way / (way @ way), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(off - along[..., None] * way, axis=-1))
        crosses = (start[1] > points[..., 1]) != (end[1] > points[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (off[..., 0] < off[..., 1] * way[0] / way[1])
    return np.where(inside, -nearest, nearest)


def joined(one: Array, other: Array, softness: float) -> Array:
    """The union of two bodies with a fillet about ``softness`` wide."""
    share = np.clip(0.5 + 0.5 * (other - one) / softness, 0.0, 1.0)
    found: Array = other + (one - other) * share - softness * share * (1.0 - share)
    return found


def without(one: Array, other: Array, softness: float) -> Array:
    """The first body with the second taken off it, the edge about ``softness`` wide."""
    return -joined(-one, other, softness)


def arc(places: list[Place], count: int) -> list[Place]:
    """``count`` places on the smooth (Catmull-Rom) curve through places."""
    knots = np.array([places[0], *places, places[-1]])
    found = []
    for at in np.linspace(0.0, len(places) - 1.0, count):
        piece = min(int(at), len(places) - 2)
        t = at - piece
        a, b, c, d = knots[piece : piece + 4]
        place = 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
        found.append(tuple(float(value) for value in place))
    return found
