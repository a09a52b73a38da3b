# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay and the measuring of volumes in a real window: what is drawn, when it is sent to the graphics card, what
Esc, undo, playback, local view and deleting do. run_window_tests.py runs it."""

import sys
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon" / "demo"))

import screenshot_scenes as scenes
import window
from blender_session import EXTENSION
from PIL import Image

TEAL = (64, 199, 219)
"""The corrected lattice's colour."""


def part(name: str) -> ModuleType:
    """A module of the installed extension."""
    return sys.modules[f"{EXTENSION}.{name}"]


def drawn(picture: Image.Image) -> int:
    """Pixels of the corrected lattice's colour in a picture of the window."""
    return int((np.abs(np.asarray(picture, np.int32) - TEAL).sum(axis=2) < 40).sum())


def require(what: str, is_so: bool) -> None:
    """Fails with these words unless it is so."""
    if not is_so:
        raise AssertionError(what)
    print(f"ok: {what}", flush=True)


def curve():
    """The measured curve of the ball."""
    return part("tool.volume_curve").read(bpy.data.objects["Ball"].modifiers[0])


class Sent:
    """Counts what is sent to the graphics card."""

    def __init__(self) -> None:
        self.count = 0
        self._module = part("tool.overlay_batches")
        self._send = self._module._send
        self._module._send = self._counting

    def _counting(self, *given):
        self.count += 1
        return self._send(*given)

    def since(self) -> int:
        """How often since last asked."""
        count, self.count = self.count, 0
        return count


def measuring(view: bpy.types.Area) -> window.Steps:
    """The modal operator, its undo, and breaking it off."""
    bpy.ops.ed.undo_push(message="before")
    with window.within(view):
        began = bpy.ops.isochor.measure_volume("INVOKE_DEFAULT")
    require("measuring runs beside the window", began == {"RUNNING_MODAL"})
    for _ in range(400):
        yield
        if curve() is not None:
            break
    require("it ends with a curve", curve() is not None and len(curve().frames) == 48)
    require("on the frame where it began", bpy.context.scene.frame_current == 13)
    for name, there in (("undo", False), ("redo", True), ("undo", False)):
        yield from window.settle()
        with window.within(view):
            getattr(bpy.ops.ed, name)()
        yield from window.settle()
        require(f"{name} takes one step", (curve() is not None) == there)
    bpy.context.scene.frame_end = 20000
    bpy.context.scene.frame_set(13)
    with window.within(view):
        bpy.ops.isochor.measure_volume("INVOKE_DEFAULT")
    for _ in range(4):
        yield
    place = bpy.context.window_manager.windows[0]
    place.event_simulate("ESC", "PRESS", x=view.x + 300, y=view.y + 300)
    place.event_simulate("ESC", "RELEASE", x=view.x + 300, y=view.y + 300)
    for _ in range(8):
        yield
    require("Esc breaks it off", curve() is None and bpy.context.scene.frame_current == 13)
    bpy.context.scene.frame_end = 48


def playing(view: bpy.types.Area, seconds: float = 3.0) -> window.Steps:
    """Plays for a while."""
    with window.within(view):
        bpy.ops.screen.animation_play()
    for _ in range(int(seconds / window.PAUSE)):
        yield
    with window.within(view):
        bpy.ops.screen.animation_cancel()
    yield from window.settle()


def following(view: bpy.types.Area) -> window.Steps:
    """What is sent when: in playback, standing still, switched off."""
    sent = Sent()
    yield from playing(view)
    require("playback is followed", sent.since() > 2)
    yield from window.settle()
    yield from window.settle()
    require("nothing is sent while nothing moves", sent.since() == 0)
    bpy.context.workspace.isochor_overlay.show = False
    yield from playing(view)
    require("nothing is sent while it is off", sent.since() == 0)
    bpy.context.workspace.isochor_overlay.show = True
    bpy.context.scene.frame_set(13)


def seen(view: bpy.types.Area, out: Path) -> window.Steps:
    """Where the lattice is drawn and where not."""
    space, ball = view.spaces.active, bpy.data.objects["Ball"]

    def see(name: str, there: bool) -> window.Steps:
        yield from window.picture(out / f"{name}.png")
        found = drawn(window.look())
        require(f"{name}: {found} pixels of it", (found > 500) == there)

    yield from see("in the view", True)
    space.overlay.show_overlays = False
    yield from see("overlays off", False)
    space.overlay.show_overlays = True
    ball.hide_set(True)
    yield from see("object hidden", False)
    ball.hide_set(False)
    space.shading.show_xray = True
    yield from see("x-ray", True)
    space.shading.show_xray = False
    bpy.ops.object.select_all(action="DESELECT")
    bpy.ops.mesh.primitive_cube_add(location=(3.0, 0.0, 0.0))
    for name, there in (("local view of another", False), ("local view left", True)):
        with window.within(view):
            bpy.ops.view3d.localview(frame_selected=False)
        yield from see(name, there)
    bpy.context.workspace.isochor_overlay.only_selected = True
    yield from see("another selected", False)
    bpy.context.workspace.isochor_overlay.only_selected = False


def losing(view: bpy.types.Area) -> window.Steps:
    """Deleting what is drawn, undo, and the extension switched off and on."""
    for name in ("Ball Lattice", "Ball"):
        bpy.data.objects.remove(bpy.data.objects[name])
        yield from window.settle()
    require("nothing is kept of what is gone", len(part("tool.overlay_batches")._batches) == 0)
    with window.within(view):
        bpy.ops.ed.undo()
    yield from window.settle()
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    yield from window.settle()
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    yield from window.settle()
    require("nothing went wrong while drawing", part("tool.overlay").complaints() == [])
    require("it stays on", bpy.context.workspace.isochor_overlay.show)


def everything(out: Path) -> window.Steps:
    """All of it, one after the other."""
    scenes.clear()
    scenes.animate_squash(scenes.lattice_of(scenes.ball()))
    view = window.area("VIEW_3D")
    view.spaces.active.show_region_ui = True
    view.spaces.active.region_3d.view_distance = 7.0
    yield from window.settle()
    window.region(view, "UI").active_panel_category = "Isochor"
    bpy.context.workspace.isochor_overlay.show = True
    bpy.context.scene.frame_set(13)
    yield from window.settle()
    yield from measuring(view)
    yield from seen(view, out)
    yield from following(view)
    yield from losing(view)


if __name__ == "__main__":
    window.main(__doc__.splitlines()[0], everything)
