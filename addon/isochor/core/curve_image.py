# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a volume curve: percent of the target over frames, before and after the correction; and PNG files."""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .canvas import Canvas, Colour

Values = NDArray[np.float64]
Picture = NDArray[np.uint8]

LEAST_SPAN = 10.0
"""Percent that the picture spans at least, so that rounding is not blown up into a mountain."""


FARTHEST = 1e12
"""Percent beyond which nothing is drawn: a mesh is not that large, its target is all but zero."""


@dataclass(frozen=True)
class Words:
    """Names of the two curves, and what the numbers on the axes are; in letters that ``tiny_font`` has."""

    plain: str = "lattice alone"
    corrected: str = "corrected"
    y_title: str = "% of target volume"
    x_title: str = "frame"


@dataclass(frozen=True)
class Look:
    """Colours, red, green and blue in 0..255, as sRGB; and the words."""

    paper: Colour
    rule: Colour
    target: Colour
    ink: Colour
    plain: Colour
    corrected: Colour
    words: Words = Words()


LIGHT = Look((250, 249, 246), (226, 226, 222), (138, 143, 156), (28, 34, 52), (190, 42, 24), (8, 104, 124))
DARK = Look((32, 34, 38), (56, 59, 65), (126, 132, 144), (222, 224, 228), (255, 112, 88), (64, 200, 220))


@dataclass(frozen=True)
class Frame:
    """Where the plot stands in the picture (pixels) and what it spans (frames, percent)."""

    left: float
    right: float
    top: float
    bottom: float
    first: float
    last: float
    low: float
    high: float

    def x(self, frames: Values) -> Values:
        """Pixels from the left."""
        return self.left + (frames - self.first) * (self.right - self.left) / (self.last - self.first)

    def y(self, percents: Values) -> Values:
        """Pixels from the top."""
        return self.bottom - (percents - self.low) * (self.bottom - self.top) / (self.high - self.low)


def percent_of(volumes: ArrayLike, targets: ArrayLike) -> Values:
    """Volumes as percent of their targets; NaN where a target is 0 or either is unknown (NaN)."""
    over, under = np.asarray(volumes, np.float64), np.asarray(targets, np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        found: Values = np.where(under == 0.0, np.nan, 100.0 * over / under)
    return found


def draw_volume_curve(
    frames: ArrayLike,
    plain: ArrayLike,
    corrected: ArrayLike,
    size: tuple[int, int] = (800, 400),
    look: Look = LIGHT,
    title: str = "",
    scale: int = 0,
) -> Picture:
    """(height, width, 4) uint8, opaque, top row first. ``frames`` (N,) rising; ``plain`` and ``corrected`` (N,)
    percent of the target, as ``percent_of`` gives, NaN or beyond FARTHEST for a gap. ``size``: width and height, at
    least 160 x 120. ``scale`` enlarges letters and lines; 0 chooses by the size. Raises ValueError for other lengths,
    no frames, frames that are no finite numbers, or a smaller size."""
    x, before, after = _columns(frames, plain, corrected)
    width, height = size
    if width < 160 or height < 120:
        raise ValueError(f"a curve needs a picture of at least 160 x 120 pixels, not {width} x {height}")
    scale = scale or max(1, round(min(width / 440, height / 220)))
    canvas = Canvas(width, height, look.paper)
    place = _place(canvas, x, np.concatenate([before, after]), scale)
    _draw_scales(canvas, place, look, scale)
    _draw_legend(canvas, look, scale, title)
    thickness = 1.6 * scale
    canvas.line(place.x(x), place.y(before), thickness, look.plain)
    canvas.line(place.x(x), place.y(after), thickness * 1.25, look.corrected)
    return canvas.picture()


def _columns(frames: ArrayLike, plain: ArrayLike, corrected: ArrayLike) -> tuple[Values, Values, Values]:
    x, before, after = (np.asarray(values, np.float64) for values in (frames, plain, corrected))
    if x.ndim != 1 or len(x) == 0 or not x.shape == before.shape == after.shape:
        raise ValueError("frames, plain and corrected must be rows of one length, of at least one frame")
    if not np.isfinite(x).all():
        raise ValueError("frames must be finite numbers")
    before, after = (np.where(np.abs(values) <= FARTHEST, values, np.nan) for values in (before, after))
    return x, before, after


def png_bytes(rgba: Picture) -> bytes:
    """A PNG file of a (height, width, 4) uint8 picture, top row first, sRGB."""
    height, width, _four = rgba.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), np.ascontiguousarray(rgba).reshape(height, -1)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    parts = ((b"IHDR", header), (b"sRGB", b"\0"), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, content) for kind, content in parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _place(canvas: Canvas, frames: Values, percents: Values, scale: int) -> Frame:
    """The plot in the picture, with room for labels."""
    low, high = _span(percents)
    first, last = float(frames[0]), float(frames[-1])
    if first == last:
        first, last = first - 1.0, last + 1.0
    widest = max(canvas.text_width(f"{tick:g}", scale) for tick in ticks(low, high, 5))
    return Frame(
        left=widest + 10.0 * scale,
        right=canvas.width - 12.0 * scale,
        top=30.0 * scale,
        bottom=canvas.height - 28.0 * scale,
        first=first,
        last=last,
        low=low,
        high=high,
    )


def _span(percents: Values) -> tuple[float, float]:
    """Lowest and highest percent of the picture: all that is known, the target, and a little room, on round numbers."""
    known = np.append(percents[np.isfinite(percents)], 100.0)
    low, high = float(known.min()), float(known.max())
    missing = max(0.0, LEAST_SPAN - (high - low)) / 2.0
    room = 0.04 * max(high - low, LEAST_SPAN)
    step = round_step((high - low + 2.0 * (missing + room)) / 5)
    lowest, highest = np.floor((low - missing - room) / step) * step, np.ceil((high + missing + room) / step) * step
    return float(max(lowest, 0.0) if low >= 0.0 else lowest), float(highest)


def round_step(step: float) -> float:
    """The next larger of 1, 2 and 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(step))
    return float(next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= step * (1.0 - 1e-9)))


def ticks(low: float, high: float, count: int, whole: bool = False) -> list[float]:
    """About ``count`` round numbers from low to high; whole numbers where asked."""
    step = round_step((high - low) / count)
    step = max(1.0, step) if whole else step
    numbers = np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1.0)
    return [float(number * step) for number in numbers]


def _draw_scales(canvas: Canvas, place: Frame, look: Look, scale: int) -> None:
    edges = np.array([place.left, place.right])
    for tick in ticks(place.low, place.high, 5):
        y = float(place.y(np.array(tick)))
        canvas.line(edges, np.array([y, y]), 1.0 * scale, look.rule)
        canvas.text(f"{tick:g}", place.left - 5 * scale, y, scale, look.ink, anchor="right")
    _draw_frames(canvas, place, look, scale)
    y = float(place.y(np.array(100.0)))
    canvas.dashes(edges, y, scale, look.target)


def _draw_frames(canvas: Canvas, place: Frame, look: Look, scale: int) -> None:
    widest = canvas.text_width(f"{place.last:g}", scale) + 16 * scale
    count = int(np.clip((place.right - place.left) / widest, 2, 10))
    below = place.bottom + 9 * scale
    numbered = ticks(place.first, place.last, count, whole=True)
    if numbered and place.x(np.array(numbered[0])) - place.left > widest:
        numbered.insert(0, place.first)
    for tick in numbered:
        x = float(place.x(np.array(tick)))
        canvas.line(np.array([x, x]), place.bottom + np.array([0.0, 3.0 * scale]), 1.0 * scale, look.ink)
        canvas.text(f"{tick:g}", x, below + scale, scale, look.ink, anchor="middle")
    canvas.line(np.array([place.left, place.right]), np.full(2, place.bottom), 1.0 * scale, look.ink)
    canvas.text(look.words.x_title, place.right, below + 11 * scale, scale, look.target, anchor="right")


def _draw_legend(canvas: Canvas, look: Look, scale: int, title: str) -> None:
    """Names of the curves in their colours, above the plot, and what the numbers are."""
    first, second = 8.0 * scale, 20.0 * scale
    heading = f"{title}: {look.words.y_title}" if title else look.words.y_title
    canvas.text(heading, 6 * scale, first, scale, look.ink)
    x = 6.0 * scale
    for name, colour in _names(look):
        canvas.line(np.array([x, x + 14 * scale]), np.full(2, second), 2.0 * scale, colour)
        canvas.text(name, x + 19 * scale, second, scale, colour)
        x += canvas.text_width(name, scale) + 32 * scale


def _names(look: Look) -> Sequence[tuple[str, Colour]]:
    return ((look.words.plain, look.plain), (look.words.corrected, look.corrected))
