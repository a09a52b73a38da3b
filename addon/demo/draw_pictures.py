# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws film strip, plot and animation from the rendered frames and volume.csv; needs no Blender."""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from bounce_table import read_table
from film_strip import draw_film_strip
from moving_picture import draw_moving_picture
from volume_plot import draw_volume_plot


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder with volume.csv, plain/ and isochor/")
    out: Path = parser.parse_args().out
    rows = read_table(out / "volume.csv")

    def frame_path(variant: str, frame: int) -> Path:
        return out / variant / f"{frame:04d}.png"

    marked = [rows[0], *(row for row in rows if row.marked_loss is not None)]
    print("drawing film-strip.png, volume.png and bounce.webp", flush=True)
    draw_film_strip(marked, frame_path, out / "film-strip.png")
    draw_volume_plot(rows, out / "volume.png")
    draw_moving_picture(rows, frame_path, out / "bounce.webp")


if __name__ == "__main__":
    main()
