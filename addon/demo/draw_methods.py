# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of figures and methods as Markdown and as a picture (Pillow)."""

from itertools import groupby
from pathlib import Path

from figure_table import METHODS, MethodRow
from film_strip import DARK, GAP, PAPER, TEAL
from PIL import Image, ImageDraw, ImageFont

HEAD = ("figure", "corrected", "points", "lattice alone", "largest error", *METHODS)
WIDTHS = (90, 220, 90, 130, 130, *(150,) * len(METHODS))
LINE = 30
STRIPE = (240, 238, 231)


def table_lines(rows: list[MethodRow]) -> list[tuple[str, ...]]:
    """A line a figure and variant, the methods side by side: the correction's length in sizes of the model, and the
    milliseconds of a frame. In plain letters: the font of the picture has no others."""
    lines = []
    for (figure, variant), methods in groupby(rows, key=lambda row: (row.figure, row.variant)):
        found = {row.method: row for row in methods}
        first = next(iter(found.values()))
        worst = max(row.error for row in found.values())
        numbers = (method_words(found.get(name)) for name in METHODS)
        change = f"{100.0 * first.change:+.1f} %"
        title = figure.removeprefix("figure-")
        lines.append((title, variant, f"{first.vertices:,}", change, f"{worst:.0e}", *numbers))
    return lines


def method_words(row: MethodRow | None) -> str:
    """Length and time; a star where another method had to stand in."""
    if row is None:
        return "-"
    star = "" if row.ran == row.method else "*"
    return f"{row.distance:.2f}{star} · {row.milliseconds:.1f} ms"


def write_markdown(place: Path, rows: list[MethodRow]) -> None:
    """The table as Markdown."""
    body = [f"| {' | '.join(line)} |" for line in (HEAD, ("---",) * len(HEAD), *table_lines(rows))]
    place.write_text("\n".join(body) + "\n", encoding="utf-8")


def draw_methods(place: Path, rows: list[MethodRow]) -> None:
    """The table as a picture."""
    lines = [HEAD, *table_lines(rows)]
    page = Image.new("RGB", (sum(WIDTHS) + 4 * GAP, len(lines) * LINE + 4 * GAP), PAPER)
    draw = ImageDraw.Draw(page)
    for number, line in enumerate(lines):
        left, top = 2 * GAP, 2 * GAP + number * LINE
        if number % 2:
            draw.rectangle((GAP, top, page.width - GAP, top + LINE), fill=STRIPE)
        for text, width in zip(line, WIDTHS):
            colour = DARK if number else TEAL
            draw.text((left + 4, top + LINE / 2), text, font=ImageFont.load_default(16), fill=colour, anchor="lm")
            left += width
    page.quantize(64).save(place, optimize=True)
