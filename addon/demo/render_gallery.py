# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the gallery's pictures in an isolated Blender and measures the volume in each (run by run_gallery.py).

Use, in Blender or a Python with bpy: render_gallery.py --zip ZIP --out FOLDER [--only PAGE ...].
"""

import argparse
import importlib
import pkgutil
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "blend_fixtures")]

import pages  # noqa: E402
from blender_session import DemoError, command_arguments, enable_cycles, install_extension, run_and_leave  # noqa: E402
from figure_table import MethodRow, method_rows, write_frames, write_methods  # noqa: E402
from gallery_tile import COLUMNS, Shot, Tile, write_csv, write_shots  # noqa: E402

TOLERANCE = 1e-6


def all_pages() -> dict[str, ModuleType]:
    """Every module of the folder pages, by its NAME, in order of its file's name."""
    names = sorted(module.name for module in pkgutil.iter_modules(pages.__path__))
    modules = [importlib.import_module(f"pages.{name}") for name in names]
    return {module.NAME: module for module in modules}


def render_page(page: ModuleType, out: Path) -> tuple[list[Shot], list[MethodRow]]:
    """Sets each of the page's pictures up in a new file, measures and renders it. A figure of the volume paper, which
    has ``build`` and ``pictures`` in the place of ``tiles``, is also measured in every frame, and by every method."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    enable_cycles()
    if hasattr(page, "tiles"):
        return render_tiles(page, page.tiles(bpy.context.scene), out), []
    from figure_stage import set_view

    figure = page.build(bpy.context.scene)
    set_view(bpy.context.scene, page.VIEW)
    shots = render_tiles(page, page.pictures(figure), out)
    write_frames(out / f"{page.NAME}.csv", figure.rows(range(1, figure.last + 1)))
    return shots, method_rows(figure)


def render_tiles(page: ModuleType, tiles: Iterable[Tile], out: Path) -> list[Shot]:
    """Measures and renders one picture after another."""
    import bpy

    shots = []
    for number, tile in enumerate(tiles):
        place = out / page.NAME / f"{number:02d}.png"
        started = time.monotonic()
        volume = measured(tile)
        bpy.context.scene.render.filepath = str(place)
        bpy.ops.render.render(write_still=True)
        shots.append(shot_of(page, place, tile, volume))
        print(f"gallery: {page.NAME} {number}: {tile.caption}, {time.monotonic() - started:.1f} s", flush=True)
    return shots


def shot_of(page: ModuleType, place: Path, tile: Tile, volume: float) -> Shot:
    """What the picture at ``place`` shows."""
    columns = getattr(page, "COLUMNS", COLUMNS)
    name = f"{page.NAME}/{place.name}"
    return Shot(page.NAME, name, tile.caption, volume, tile.whole, tile.must_be, tile.note, columns)


def measured(tile: Tile) -> float:
    """Signed volume of what Blender draws now, float64, in the object's own space."""
    import bpy
    from surface_measures import drawn_arrays, enclosed_volume

    evaluated: Any = bpy.data.objects[tile.object_name].evaluated_get(bpy.context.evaluated_depsgraph_get())
    return enclosed_volume(*drawn_arrays(evaluated))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    known = all_pages()
    parser.add_argument("--only", nargs="+", choices=list(known), default=list(known), metavar="PAGE")
    chosen = parser.parse_args(command_arguments())
    install_extension(chosen.zip.resolve())
    rendered = [render_page(known[name], chosen.out.resolve()) for name in chosen.only]
    shots = [shot for page, _ in rendered for shot in page]
    write_methods(chosen.out / "figures.csv", [row for _, methods in rendered for row in methods])
    write_shots(chosen.out / "gallery.json", shots)
    write_csv(chosen.out / "gallery.csv", shots)
    wrong = [f"{shot.page}, {shot.caption}: {shot.error:.1e}" for shot in shots if (shot.error or 0.0) > TOLERANCE]
    if wrong:
        raise DemoError("the volume is not what it must be:\n  " + "\n  ".join(wrong))


if __name__ == "__main__":
    run_and_leave(main)
