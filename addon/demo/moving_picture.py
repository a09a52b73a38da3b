# SPDX-License-Identifier: GPL-3.0-or-later
"""The animation: plain lattice on the left, Isochor on the right, as a looping animated WebP (Pillow)."""

from pathlib import Path

from bounce_table import BounceRow
from film_strip import FramePath
from PIL import Image, ImageDraw, ImageFont

TITLE_HEIGHT = 34
FRAMES_PER_SECOND = 24
PAPER = (250, 249, 246)
TITLES = (("plain", "Lattice modifier", (190, 42, 24)), ("isochor", "Isochor", (8, 104, 124)))


def _draw_frame(row: BounceRow, frame_path: FramePath) -> Image.Image:
    pictures = [Image.open(frame_path(variant, row.frame)) for variant, _, _ in TITLES]
    width, height = pictures[0].size
    frame = Image.new("RGB", (2 * width, height + TITLE_HEIGHT), PAPER)
    draw = ImageDraw.Draw(frame)
    font = ImageFont.load_default(18)
    for column, (picture, (variant, title, colour)) in enumerate(zip(pictures, TITLES)):
        frame.paste(picture, (column * width, TITLE_HEIGHT))
        change = row.plain_change if variant == "plain" else row.isochor_error
        text = f"{title}: volume {100 * (1 + change):.0f} %"
        draw.text((column * width + 14, TITLE_HEIGHT / 2), text, font=font, fill=colour, anchor="lm")
    return frame


def draw_moving_picture(rows: list[BounceRow], frame_path: FramePath, output: Path) -> None:
    """Writes the frames of all `rows` (BounceRows), both variants side by side, to the WebP `output`."""
    first, *others = [_draw_frame(row, frame_path) for row in rows]
    duration = round(1000 / FRAMES_PER_SECOND)
    first.save(output, save_all=True, append_images=others, duration=duration, loop=0, quality=80, method=4)
