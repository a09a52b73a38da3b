# SPDX-License-Identifier: GPL-3.0-or-later
"""Lays the gallery's pictures out, one page a strip or a grid with captions (Pillow); needs no Blender."""

import argparse
import sys
from itertools import groupby
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from draw_methods import draw_methods, write_markdown  # noqa: E402
from figure_table import read_methods  # noqa: E402
from film_strip import DARK, GAP, PAPER, RED, TEAL  # noqa: E402
from gallery_tile import Shot, read_shots  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402

CAPTION, NOTE = 58, 24
"""Height of what is said under a picture, and of the line more where the page has notes."""


def draw_page(shots: list[Shot], out: Path, place: Path) -> None:
    """Draws the shots of one page, side by side, with caption and volume under each."""
    width, height = Image.open(out / shots[0].file).size
    columns = min(shots[0].columns, len(shots))
    rows = -(-len(shots) // columns)
    across, down = width + GAP, height + CAPTION + GAP + (NOTE if any(shot.note for shot in shots) else 0)
    page = Image.new("RGB", (columns * across + GAP, rows * down + GAP), PAPER)
    for number, shot in enumerate(shots):
        left, top = GAP + number % columns * across, GAP + number // columns * down
        page.paste(Image.open(out / shot.file), (left, top))
        _draw_caption(ImageDraw.Draw(page), left + 6, top + height + 6, shot)
    page.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2).save(place, optimize=True)


def _draw_caption(draw: ImageDraw.ImageDraw, left: int, top: int, shot: Shot) -> None:
    colour = RED if shot.error is None else TEAL
    draw.text((left, top), shot.caption, font=ImageFont.load_default(20), fill=DARK)
    draw.text((left, top + 26 + NOTE), shot.note, font=ImageFont.load_default(17), fill=DARK)
    draw.text((left, top + 26), volume_words(shot), font=ImageFont.load_default(17), fill=colour)


def volume_words(shot: Shot) -> str:
    """Volume as a share of that at rest; where one is promised, also how exactly it came out."""
    share = f"volume {100.0 * shot.volume / shot.whole:.0f} %"
    return share if shot.error is None else f"{share}, error {shot.error:.0e}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder with gallery.json and the pictures")
    out: Path = parser.parse_args().out
    for name, shots in groupby(read_shots(out / "gallery.json"), key=lambda shot: shot.page):
        draw_page(list(shots), out, out / f"{name}.png")
        print(out / f"{name}.png")
    methods = read_methods(out / "figures.csv")
    if methods:
        write_markdown(out / "figures.md", methods)
        draw_methods(out / "figures.png", methods)
        print(out / "figures.png")


if __name__ == "__main__":
    main()
