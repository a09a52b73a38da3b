# SPDX-License-Identifier: GPL-3.0-or-later
"""The film strip: the plain lattice above, Isochor below, one column a marked frame (Pillow)."""

from collections.abc import Callable
from pathlib import Path

from bounce_table import BounceRow
from PIL import Image, ImageDraw, ImageFont

Colour = tuple[int, int, int]
FramePath = Callable[[str, int], Path]

GAP = 6
TITLE_HEIGHT = 46
PAPER = (250, 249, 246)
DARK = (28, 34, 52)
RED = (190, 42, 24)
TEAL = (8, 104, 124)


def _row_captions(rows: list[BounceRow], name: str) -> list[str]:
    if name == "plain":
        return ["at rest" if row.marked_loss is None else f"{-100 * row.plain_change:.0f} % lost" for row in rows]
    return ["at rest" if row.marked_loss is None else f"{100 * (1 + row.isochor_error):.0f} % kept" for row in rows]


def _draw_caption(draw: ImageDraw.ImageDraw, position: tuple[float, float], text: str, colour: Colour) -> None:
    font = ImageFont.load_default(20)
    right, top = position
    left = right - draw.textlength(text, font=font)
    draw.rounded_rectangle((left - 9, top - 7, right + 9, top + 24), 7, fill=PAPER)
    draw.text(position, text, font=font, fill=colour, anchor="rt")


def draw_film_strip(rows: list[BounceRow], frame_path: FramePath, output: Path) -> None:
    """Draws the strip of `rows` (BounceRows) to `output`; `frame_path(variant, frame)` names each rendered picture."""
    width, height = Image.open(frame_path("plain", rows[0].frame)).size
    columns = len(rows)
    size = (columns * width + (columns + 1) * GAP, 2 * (TITLE_HEIGHT + height) + 3 * GAP)
    strip = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(strip)
    title = ImageFont.load_default(25)
    titles = (
        ("plain", "Blender\N{RIGHT SINGLE QUOTATION MARK}s Lattice modifier: the ball shrinks as it is squashed", RED),
        ("isochor", "Isochor, same lattice: the ball spreads and keeps its volume", TEAL),
    )
    for line, (variant, text, colour) in enumerate(titles):
        top = line * (TITLE_HEIGHT + height + GAP)
        draw.text((2 * GAP, top + TITLE_HEIGHT / 2 + GAP / 2), text, font=title, fill=colour, anchor="lm")
        for column, (row, caption) in enumerate(zip(rows, _row_captions(rows, variant))):
            left = GAP + column * (width + GAP)
            strip.paste(Image.open(frame_path(variant, row.frame)), (left, top + TITLE_HEIGHT))
            _draw_caption(draw, (left + width - 18, top + TITLE_HEIGHT + 16), caption, colour)
            draw.text(
                (left + 14, top + TITLE_HEIGHT + 18),
                f"frame {row.frame}",
                font=ImageFont.load_default(17),
                fill=DARK,
                anchor="lt",
            )
    strip.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2).save(output, optimize=True)
