# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture to draw on: antialiased lines, dashes and small text in opaque colours."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .tiny_font import Mask, text_mask

Values = NDArray[np.float64]
Colour = tuple[int, int, int]
Anchor = Literal["left", "middle", "right"]


class Canvas:
    """Pixels of one size; places are in pixels from the left and from the top, a pixel's middle at its half."""

    def __init__(self, width: int, height: int, paper: Colour) -> None:
        self.width, self.height = width, height
        self._pixels = np.empty((height, width, 3), np.float32)
        self._pixels[:] = paper

    def picture(self) -> NDArray[np.uint8]:
        """(height, width, 4) uint8, opaque, top row first."""
        colours = np.rint(self._pixels).astype(np.uint8)
        return np.concatenate([colours, np.full((self.height, self.width, 1), 255, np.uint8)], axis=2)

    def line(self, x: Values, y: Values, thickness: float, colour: Colour) -> None:
        """A line through the points (N,) with round joints; it breaks at NaN, and a point alone is a dot."""
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            return
        coverage = np.zeros((self.height, self.width), np.float32)
        for place in np.flatnonzero(known):
            after = place + 1 if place + 1 < len(x) and known[place + 1] else place
            if after != place or place == 0 or not known[place - 1]:
                self._cover(coverage, (x[place], y[place]), (x[after], y[after]), thickness)
        rows = _within(y[known].min() - thickness, y[known].max() + thickness, self.height)
        self._blend(coverage[rows], rows.start, 0, colour)

    def dashes(self, x: Values, y: float, scale: int, colour: Colour) -> None:
        """A dashed horizontal line from x[0] to x[1]."""
        starts = np.arange(x[0], x[1], 7.0 * scale)
        ends = np.minimum(starts + 4.0 * scale, x[1])
        pieces = np.stack([starts, ends, np.full_like(starts, np.nan)], axis=1).reshape(-1)
        self.line(pieces, np.full_like(pieces, y), 1.0 * scale, colour)

    def text(self, text: str, x: float, y: float, scale: int, colour: Colour, anchor: Anchor = "left") -> None:
        """A line of text whose capitals are centred on y and which starts, is centred, or ends at x."""
        mask = text_mask(text, scale)
        shift = {"left": 0.0, "middle": mask.shape[1] / 2.0, "right": float(mask.shape[1])}[anchor]
        self._blend(mask, round(y - 3.5 * scale), round(x - shift), colour)

    def text_width(self, text: str, scale: int) -> int:
        """Pixels that a line of text takes."""
        return int(text_mask(text, scale).shape[1])

    def _cover(self, coverage: Mask, start: tuple[float, float], end: tuple[float, float], thickness: float) -> None:
        """Raises coverage to that of one straight piece, as far as it lies in the picture."""
        reach = thickness / 2.0 + 1.0
        columns = _within(min(start[0], end[0]) - reach, max(start[0], end[0]) + reach, self.width)
        rows = _within(min(start[1], end[1]) - reach, max(start[1], end[1]) + reach, self.height)
        x = np.arange(columns.start, columns.stop, dtype=np.float32)[None, :] + np.float32(0.5 - start[0])
        y = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None] + np.float32(0.5 - start[1])
        dx, dy = np.float32(end[0] - start[0]), np.float32(end[1] - start[1])
        along = np.clip((x * dx + y * dy) / max(dx * dx + dy * dy, np.float32(1e-12)), 0.0, 1.0)
        distance = np.hypot(x - along * dx, y - along * dy)
        piece = np.clip(np.float32(thickness / 2.0 + 0.5) - distance, 0.0, 1.0)
        np.maximum(coverage[rows, columns], piece, out=coverage[rows, columns])

    def _blend(self, mask: Mask, top: int, left: int, colour: Colour) -> None:
        """Lays the colour over the picture where the mask covers it; what reaches outside is cut off."""
        rows, columns = _within(top, top + mask.shape[0], self.height), _within(left, left + mask.shape[1], self.width)
        part = mask[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left, None]
        here = self._pixels[rows, columns]
        here += part * (np.array(colour, np.float32) - here)


def _within(low: float, high: float, size: int) -> slice:
    """The whole pixels from low to high that a side of this size has."""
    start = int(np.clip(np.floor(low), 0, size))
    return slice(start, max(start, int(np.clip(np.ceil(high), 0, size))))
