# SPDX-License-Identifier: GPL-3.0-or-later
"""Lays the gallery's pictures out, one page a strip or a grid with captions (Pillow); needs no Blender."""

import argparse
import sys
from itertools import groupby
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from film_strip import DARK, GAP, PAPER, RED, TEAL  # noqa: E402
from gallery_tile import Shot, read_shots  # noqa: E402
from PIL import Image, ImageDraw, ImageFont  # noqa: E402

CAPTION = 58
COLUMNS = 4


def draw_page(shots: list[Shot], out: Path, place: Path) -> None:
    """Draws the shots of one page, at most COLUMNS side by side, with caption and volume under each."""
    width, height = Image.open(out / shots[0].file).size
    columns = min(COLUMNS, len(shots))
    rows = -(-len(shots) // columns)
    page = Image.new("RGB", (columns * (width + GAP) + GAP, rows * (height + CAPTION + GAP) + GAP), PAPER)
    for number, shot in enumerate(shots):
        left, top = GAP + number % columns * (width + GAP), GAP + number // columns * (height + CAPTION + GAP)
        page.paste(Image.open(out / shot.file), (left, top))
        _draw_caption(ImageDraw.Draw(page), left + 6, top + height + 6, shot)
    page.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2).save(place, optimize=True)


def _draw_caption(draw: ImageDraw.ImageDraw, left: int, top: int, shot: Shot) -> None:
    colour = RED if shot.error is None else TEAL
    draw.text((left, top), shot.caption, font=ImageFont.load_default(20), fill=DARK)
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


if __name__ == "__main__":
    main()
