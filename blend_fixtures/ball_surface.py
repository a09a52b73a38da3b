# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of the demonstration ball: bands, grooves, dimples and raised lettering on a unit sphere (numpy only).

Fine detail is what shows a wrong deformation. Every feature is a signed distance on the sphere (radians, negative
inside), which gives both its relief and, through the material, its colour.
"""

from dataclasses import dataclass

import numpy as np
from lettering import distance_to_segments, word_segments
from numpy.typing import NDArray
from relief import inside

Values = NDArray[np.float64]

WORD = "ISOCHOR"
WORD_COPIES = 2
LETTER_HEIGHT = 0.33
STROKE_HALF_WIDTH = 0.040
DOT_RADIUS = 0.070
BAND_HALF_WIDTH = 0.30
GROOVE_HALF_WIDTH = 0.022
DIMPLES_ON_SPHERE = 190
DIMPLE_RADIUS = 0.092
PLUG_RADIUS = 0.20  # the plain disc round each pole
LETTER_RELIEF = 0.018
GROOVE_RELIEF = -0.020
DIMPLE_RELIEF = -0.024
EDGE_SOFTNESS = 0.030  # about one and a half edges of an icosphere with 40,962 vertices


@dataclass(frozen=True)
class BallSurface:
    """Radius factor (V,) and the signed distances (V,), radians, that colour the ball."""

    radius: Values
    latitude: Values
    ink: Values
    dimple: Values
    groove: Values


def make_ball_surface(directions: Values) -> BallSurface:
    """Surface over the unit vectors `directions` (V, 3), float64; the word faces -Y and +Y, the poles are on Z."""
    latitude = np.arcsin(np.clip(directions[:, 2], -1, 1))
    longitude = np.arctan2(directions[:, 1], directions[:, 0]) + np.pi / 2  # 0 towards -Y
    ink = _ink_distance(longitude, latitude)
    dimple = _dimple_distance(directions)
    groove = _groove_distance(latitude)
    radius = (
        1.0
        + LETTER_RELIEF * inside(ink, EDGE_SOFTNESS)
        + GROOVE_RELIEF * inside(groove, EDGE_SOFTNESS)
        + DIMPLE_RELIEF * inside(dimple, DIMPLE_RADIUS)
    )
    return BallSurface(radius, latitude, ink, dimple, groove)


def _ink_distance(longitude: Values, latitude: Values) -> Values:
    """To the copies of WORD round the equator and a dot between each two of them."""
    sector = 2 * np.pi / WORD_COPIES
    across = (longitude + sector / 2) % sector - sector / 2
    word = distance_to_segments(np.column_stack((across, latitude)), word_segments(WORD, LETTER_HEIGHT))
    dot = np.hypot(sector / 2 - np.abs(across), latitude)
    return np.minimum(word - STROKE_HALF_WIDTH, dot - DOT_RADIUS)


def _groove_distance(latitude: Values) -> Values:
    """To the seams beside the band and round the discs at the poles."""
    seams = (BAND_HALF_WIDTH, np.pi / 2 - PLUG_RADIUS)
    nearest: Values = np.min([np.abs(np.abs(latitude) - seam) for seam in seams], axis=0)
    return nearest - GROOVE_HALF_WIDTH


def _dimple_distance(directions: Values) -> Values:
    """To the rims of the dimples, spread evenly over both caps (a Fibonacci spiral, clear of the seams)."""
    index = np.arange(DIMPLES_ON_SPHERE)
    height = 1 - 2 * (index + 0.5) / DIMPLES_ON_SPHERE
    turn = index * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - height * height)
    centres = np.column_stack((ring * np.cos(turn), ring * np.sin(turn), height))
    centre_latitude = np.abs(np.arcsin(height))
    clearance = DIMPLE_RADIUS + 2 * GROOVE_HALF_WIDTH
    clear = (centre_latitude > BAND_HALF_WIDTH + clearance) & (centre_latitude < np.pi / 2 - PLUG_RADIUS - clearance)
    nearest: Values = np.arccos(np.clip(np.max(directions @ centres[clear].T, axis=1), -1, 1))
    return nearest - DIMPLE_RADIUS
