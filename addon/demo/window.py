# SPDX-License-Identifier: GPL-3.0-or-later
"""Working a real Blender window from a script: its areas and panels, waiting until it has drawn, and pictures of it.

Runs inside Blender on an X display; Blender's Python needs Pillow.
"""

import argparse
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
from blender_session import command_arguments, install_extension
from PIL import Image, ImageGrab

PAUSE = 0.25
"""Seconds between two looks at the window."""
LOOKS = 60
"""How often at most until it stands still."""

Steps = Iterator[None]
"""What is done in a window: each yield lets Blender handle events and draw."""


def area(kind: str) -> bpy.types.Area:
    """The largest area of a kind, such as VIEW_3D."""
    found = [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind]
    return max(found, key=lambda area: area.width * area.height)


def region(place: bpy.types.Area, kind: str) -> bpy.types.Region:
    """A region of an area, such as UI."""
    return next(region for region in place.regions if region.type == kind)


def within(place: bpy.types.Area, kind: str = "WINDOW") -> Any:
    """A context in which operators work in that area and region."""
    window = bpy.context.window_manager.windows[0]
    return bpy.context.temp_override(window=window, screen=window.screen, area=place, region=region(place, kind))


def move_edge(x: int, y: int, pixels: int) -> None:
    """Moves the edge between areas at that place to the right, or up, where the mouse does not keep Blender from it."""
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        if bpy.ops.screen.area_move.poll():
            bpy.ops.screen.area_move(x=x, y=y, delta=pixels)


def redraw() -> None:
    """Asks every area to draw itself."""
    for window in bpy.context.window_manager.windows:
        for place in window.screen.areas:
            place.tag_redraw()


def look() -> Image.Image:
    """What the display shows."""
    return ImageGrab.grab(xdisplay=os.environ["DISPLAY"]).convert("RGB")


def settle() -> Steps:
    """Waits until the window has drawn and stands still."""
    redraw()
    yield
    before = look()
    for _ in range(LOOKS):
        yield
        now = look()
        if now.tobytes() == before.tobytes():
            return
        before = now
    raise RuntimeError("the window does not come to rest")


def picture(place: Path, around: bpy.types.Area | bpy.types.Region | None = None) -> Steps:
    """Saves a picture of the window, or of an area or region of it, once it stands still."""
    yield from settle()
    whole = look()
    if around is not None:
        top = whole.height - around.y - around.height
        whole = whole.crop((around.x, top, around.x + around.width, top + around.height))
    place.parent.mkdir(parents=True, exist_ok=True)
    whole.save(place, optimize=True)
    print(f"{place.name}: {whole.width} x {whole.height}", flush=True)


def main(description: str, everything: Callable[[Path], Steps]) -> None:
    """Installs the extension that the command line names, and takes the steps with the folder for their pictures."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    chosen = parser.parse_args(command_arguments())
    bpy.context.preferences.view.show_splash = False
    install_extension(chosen.zip)
    run(lambda: everything(chosen.out.resolve()))


def run(begin: Callable[[], Steps]) -> None:
    """Takes the steps while Blender runs, and ends the process with status 0, or 1 where one of them fails."""
    steps = begin()

    def advance() -> float:
        status: int | None = 1
        try:
            next(steps)
            status = None
        except StopIteration:
            status = 0
        finally:
            if status is not None:
                leave(status)
        return PAUSE

    bpy.app.timers.register(advance, first_interval=1.0, persistent=True)


def leave(status: int) -> None:
    """Ends the process at once, and says why where something failed."""
    if sys.exception():
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
