# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances to a word written with round strokes, for raised lettering on a surface (numpy only).

A letter is a few polylines in a box of height 1; a word sets its letters side by side, centred on the origin.
"""

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Polyline = NDArray[np.float64]  # (points, 2)

LETTER_GAP = 0.30
ARC_POINTS = 24


def _arc(centre: Point, radii: Point, start_degrees: float, end_degrees: float) -> Polyline:
    angles = np.radians(np.linspace(start_degrees, end_degrees, ARC_POINTS))
    return np.column_stack((centre[0] + radii[0] * np.cos(angles), centre[1] + radii[1] * np.sin(angles)))


def _line(*points: Point) -> Polyline:
    return np.array(points, dtype=np.float64)


def _join(*strokes: Polyline) -> Polyline:
    return np.concatenate(strokes)


# Letter -> (width, strokes); coordinates in heights of the letter, baseline at 0.
LETTERS: dict[str, tuple[float, list[Polyline]]] = {
    "C": (0.66, [_arc((0.36, 0.5), (0.36, 0.5), 48, 312)]),
    "H": (0.64, [_line((0, 0), (0, 1)), _line((0.64, 0), (0.64, 1)), _line((0, 0.5), (0.64, 0.5))]),
    "I": (0.0, [_line((0, 0), (0, 1))]),
    "O": (0.72, [_arc((0.36, 0.5), (0.36, 0.5), 0, 360)]),
    "R": (
        0.62,
        [
            _join(_line((0, 0), (0, 1), (0.34, 1)), _arc((0.34, 0.75), (0.26, 0.25), 90, -90), _line((0, 0.5))),
            _line((0.30, 0.5), (0.62, 0)),
        ],
    ),
    "S": (
        0.60,
        [_join(_arc((0.30, 0.75), (0.28, 0.25), 35, 270), _arc((0.30, 0.25), (0.30, 0.25), 90, -145))],
    ),
}


def word_segments(word: str, height: float) -> NDArray[np.float64]:
    """Segments (S, 2, 2) of the strokes of `word`, in the plane, `height` tall and centred on the origin.

    Raises KeyError for a letter that LETTERS lacks.
    """
    strokes: list[Polyline] = []
    pen = 0.0
    for letter in word:
        width, letter_strokes = LETTERS[letter]
        strokes += [stroke + (pen, -0.5) for stroke in letter_strokes]
        pen += width + LETTER_GAP
    shift = np.array(((pen - LETTER_GAP) / 2, 0.0))
    segments = [np.stack((stroke[:-1], stroke[1:]), axis=1) for stroke in strokes]
    centred: NDArray[np.float64] = (np.concatenate(segments) - shift) * height
    return centred


def distance_to_segments(points: NDArray[np.float64], segments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance (N,) of each of `points` (N, 2) to the nearest of `segments` (S, 2, 2), in the plane's unit."""
    nearest = np.full(len(points), np.inf)
    for start, end in segments:
        along = end - start
        length_squared = float(along @ along)
        offset = points - start
        share = np.clip(offset @ along / length_squared, 0, 1) if length_squared else np.zeros(len(points))
        nearest = np.minimum(nearest, np.linalg.norm(offset - share[:, None] * along, axis=1))
    return nearest
