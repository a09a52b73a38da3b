# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the pictures that the documentation shows from out/gallery into docs/pictures, each small enough."""

import argparse
import re
import shutil
import sys
from pathlib import Path

from PIL import Image

SHOWN = re.compile(r"!\[[^\]]*\]\((?:\.\./)?pictures/([\w-]+\.png)\)")
WIDEST = 1600
EACH, ALL = 250_000, 5_000_000
"""Bytes allowed."""


def shown_pictures(docs: Path) -> set[str]:
    """File names of the pictures in docs/pictures that any page shows."""
    return {name for page in docs.rglob("*.md") for name in SHOWN.findall(page.read_text(encoding="utf-8"))}


def publish(source: Path, place: Path) -> None:
    """Writes the picture in 256 colours, or in fewer where it would be too large; one that has few is left as it is."""
    picture = Image.open(source)
    if picture.mode == "P" and picture.width <= WIDEST:
        shutil.copyfile(source, place)
        return
    picture = picture.convert("RGB")
    picture.thumbnail((WIDEST, WIDEST))
    for colours in (256, 128, 64):
        few = picture.quantize(colours, Image.Quantize.MAXCOVERAGE, kmeans=2)
        picture.quantize(palette=few, dither=Image.Dither.FLOYDSTEINBERG).save(place, optimize=True)
        if place.stat().st_size <= EACH:
            return


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gallery", type=Path, required=True, help="folder that the gallery was rendered into")
    parser.add_argument("--docs", type=Path, required=True, help="folder of the documentation")
    chosen = parser.parse_args()
    target: Path = chosen.docs / "pictures"
    target.mkdir(parents=True, exist_ok=True)
    total, missing = 0, []
    for name in sorted(shown_pictures(chosen.docs)):
        found = [place for place in (chosen.gallery / name, chosen.gallery / "screenshots" / name) if place.is_file()]
        if found:
            publish(found[0], target / name)
        elif not (target / name).is_file():
            missing.append(name)
        if (target / name).is_file():
            size = (target / name).stat().st_size
            total += size
            print(f"{target / name}: {size // 1000} kB{'' if found else ', not made anew'}")
    if missing or total > ALL:
        sys.exit(f"error: {', '.join(missing) or 'none'} missing; {total // 1000} kB of {ALL // 1000} allowed")


if __name__ == "__main__":
    main()
