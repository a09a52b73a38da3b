# SPDX-License-Identifier: GPL-3.0-or-later
"""Pinning with the mouse in a real window: a click puts the pin where the surface is drawn, Esc and clicks beside it
put none, undo takes one step, and moving the empty moves the surface. run_window_tests.py runs it."""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon" / "demo"))

import screenshot_scenes as scenes
import window
from bpy_extras import view3d_utils


def require(what: str, is_so: bool) -> None:
    """Fails with these words unless it is so."""
    if not is_so:
        raise AssertionError(what)
    print(f"ok: {what}", flush=True)


def event(kind: str, value: str, x: int, y: int) -> None:
    """An event of the mouse or the keyboard at a place in the window."""
    bpy.context.window_manager.windows[0].event_simulate(kind, value, x=x, y=y)


def press(kind: str, x: int, y: int) -> window.Steps:
    """Pressed and let go."""
    event("MOUSEMOVE", "NOTHING", x, y)
    for value in ("PRESS", "RELEASE"):
        yield
        event(kind, value, x, y)
    for _ in range(4):
        yield


def invoke(view: bpy.types.Area) -> None:
    """Begins to pin, as the button does."""
    with window.within(view):
        require("it waits for a click", bpy.ops.isochor.add_pin("INVOKE_DEFAULT") == {"RUNNING_MODAL"})


def empties() -> list[bpy.types.Object]:
    """All pins."""
    return [obj for obj in bpy.data.objects if obj.type == "EMPTY"]


def drawn_at(view: bpy.types.Area, obj: bpy.types.Object) -> tuple[int, int]:
    """Where an object's origin is in the window, in pixels."""
    region = window.region(view, "WINDOW")
    place = view3d_utils.location_3d_to_region_2d(region, region.data, obj.matrix_world.translation)
    return round(region.x + place.x), round(region.y + place.y)


def nearest(obj: bpy.types.Object, point: np.ndarray) -> float:
    """How far the surface that is drawn is from a point."""
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    _found, near, *_ = shown.closest_point_on_mesh(shown.matrix_world.inverted() @ point)
    return float((shown.matrix_world @ near - point).length)


def everything(out: Path) -> window.Steps:
    """All of it, one after the other."""
    scenes.clear()
    ball = scenes.ball()
    scenes.shape(scenes.lattice_of(ball), scenes.squash)
    view = window.area("VIEW_3D")
    view.spaces.active.show_region_ui = True
    view.spaces.active.region_3d.view_distance = 7.0
    yield from window.settle()
    window.region(view, "UI").active_panel_category = "Isochor"
    bpy.ops.ed.undo_push(message="before")
    x, y = drawn_at(view, ball)
    invoke(view)
    yield from press("ESC", x, y)
    require("Esc puts none", not empties())
    invoke(view)
    yield from press("LEFTMOUSE", view.x + 120, view.y + 60)
    require("a click beside the surface puts none, and waits on", not empties())
    yield from press("LEFTMOUSE", x + 30, y + 20)
    require("a click on the surface puts one", len(empties()) == 1)
    pin = empties()[0]
    found = drawn_at(view, pin)
    missed = np.abs(np.subtract(found, (x + 30, y + 20))).max()
    require(f"where it was clicked, to within {missed} pixels", missed <= 1)
    require("on the surface", nearest(ball, pin.matrix_world.translation) < 1e-5)
    require("which is then chosen", bpy.context.view_layer.objects.active == pin and pin.select_get())
    yield from window.picture(out / "pinned.png")
    pin.location.z += 0.4
    yield from window.picture(out / "pulled.png")
    require("the surface follows", nearest(ball, pin.matrix_world.translation) < 1e-5)
    with window.within(view):
        bpy.ops.ed.undo()
    yield from window.settle()
    require("undo takes one step", not empties() and "Ball Pins" not in bpy.data.collections)


if __name__ == "__main__":
    window.main(__doc__.splitlines()[0], everything)
