# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the real window for the documentation: the panels, the overlay, the volume curve.

Use, on an X display, with BLENDER_USER_RESOURCES naming an empty folder (run_screenshots.py sees to both):
    blender --factory-startup --window-geometry 0 0 1600 1000 --python screenshots.py -- --zip ….zip --out FOLDER
"""

import sys
from math import radians
from pathlib import Path
from typing import Any

import bpy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import screenshot_scenes as scenes  # noqa: E402
import window  # noqa: E402
from blender_session import EXTENSION  # noqa: E402
from volume_lattice import find_volume_lattice, set_input  # noqa: E402


def opened(name: str) -> type:
    """A panel that starts closed, registered in its place as one that starts open, because a script cannot open one.
    ``closed`` puts the panel itself back."""
    panel = getattr(bpy.types, name)
    bpy.utils.unregister_class(panel)
    twin = type(f"{name}_open", (panel,), {"bl_options": set(panel.bl_options) - {"DEFAULT_CLOSED"}})
    bpy.utils.register_class(twin)
    return twin


def closed(twin: type) -> None:
    """Undoes ``opened``."""
    bpy.utils.unregister_class(twin)
    bpy.utils.register_class(twin.__bases__[0])


def set_up_window() -> window.Steps:
    """Sidebar on our tab, properties on the modifiers."""
    view = window.area("VIEW_3D")
    view.spaces.active.show_region_ui = True
    yield from window.settle()
    window.region(view, "UI").active_panel_category = "Isochor"
    properties = window.area("PROPERTIES")
    properties.spaces.active.context = "MODIFIER"
    window.move_edge(properties.x - 1, properties.y + 100, -80)
    window.move_edge(view.x + 200, view.y - 1, -60)
    yield from window.settle()


def shading() -> None:
    """Plain shading in the objects' own colours, no cursor, no relations."""
    space = window.area("VIEW_3D").spaces.active
    space.shading.color_type = "OBJECT"
    space.shading.show_cavity = True
    space.overlay.show_cursor = False
    space.overlay.show_relationship_lines = False
    space.overlay.show_object_origins = False


def look_from(distance: float, height: float, turn: tuple[float, float]) -> None:
    """Places the 3D View's eye: ``turn`` degrees up from straight down, and around."""
    from mathutils import Euler

    eye = window.area("VIEW_3D").spaces.active.region_3d
    eye.view_perspective = "PERSP"
    eye.view_rotation = Euler((radians(turn[0]), 0.0, radians(turn[1]))).to_quaternion()
    eye.view_location, eye.view_distance = (0.0, 0.0, height), distance


def overlay(**wanted: Any) -> None:
    """Sets the overlay; what is not named has its default."""
    settings = bpy.context.workspace.isochor_overlay
    for name in settings.bl_rna.properties.keys():  # noqa: SIM118
        if name not in ("rna_type", "name"):
            settings.property_unset(name)
    for name, value in wanted.items():
        setattr(settings, name, value)


def just_added(out: Path) -> window.Steps:
    """A ball, and the lattice that isochor.add fits to it."""
    scenes.clear()
    scenes.ball()
    look_from(6.5, 0.0, (66.0, 32.0))
    yield from window.picture(out / "added.png")


def squashed(out: Path) -> window.Steps:
    """The lattice squashed: the numbers, and where the correction put its points."""
    lattice = scenes.lattice_of(bpy.context.object)
    scenes.shape(lattice, scenes.squash)
    overlay(show=True)
    panel = opened("VIEW3D_PT_isochor_overlay")
    yield from window.picture(out / "overlay.png")
    yield from window.picture(out / "sidebar.png", window.region(window.area("VIEW_3D"), "UI"))
    yield from window.picture(out / "modifier.png", window.area("PROPERTIES"))
    closed(panel)


def deformed_space(out: Path) -> window.Steps:
    """A column twisted and bent, with the lines of the space that it stands in."""
    scenes.clear()
    lattice = scenes.lattice_of(scenes.column())
    scenes.shape(lattice, scenes.twist_and_lean)
    lattice.hide_set(True)
    look_from(8.0, 0.0, (72.0, 28.0))
    overlay(show=True, show_isolines=True, show_lattice=False, show_points=False, divisions=6)
    yield from window.picture(out / "deformed-space.png", window.area("VIEW_3D"))
    overlay(show=True, show_isolines=True, divisions=6)
    yield from window.picture(out / "deformed-space-and-lattice.png", window.area("VIEW_3D"))


def folded(out: Path) -> window.Steps:
    """A ball whose lattice folds over itself: the overlay marks where."""
    scenes.clear()
    lattice = scenes.lattice_of(scenes.ball())
    scenes.shape(lattice, scenes.push_through)
    lattice.hide_set(True)
    look_from(6.5, 0.0, (66.0, 32.0))
    overlay(show=True, show_folds=True, show_points=False)
    yield from window.picture(out / "folds.png", window.area("VIEW_3D"))


def animated(out: Path) -> window.Steps:
    """A column twisted and bent by numbers, and the panel that they stand in."""
    scenes.clear()
    column = scenes.column()
    scenes.lattice_of(column).hide_set(True)
    modifier = find_volume_lattice(column)
    for name, value in (("Squash", 1.1), ("Taper", -0.3), ("Twist", radians(90.0)), ("Bend", radians(60.0))):
        set_input(modifier, name, value)
    set_input(modifier, "Axes", (1.0, 1.0, 0.0))
    overlay()
    look_from(8.5, 0.0, (72.0, 28.0))
    panel = opened("VIEW3D_PT_isochor_animate")
    yield from window.picture(out / "animate-panel.png")
    closed(panel)


def volume_curve(out: Path) -> window.Steps:
    """A bounce measured: the curve in the sidebar, and as an image."""
    scenes.clear()
    ball = scenes.ball()
    scenes.animate_squash(scenes.lattice_of(ball))
    overlay(show=True)
    look_from(6.5, 0.0, (66.0, 32.0))
    panel = opened("VIEW3D_PT_isochor_volume_curve")
    bpy.ops.isochor.measure_volume()
    bpy.ops.isochor.volume_image()
    bpy.context.scene.frame_set(13)
    yield from window.picture(out / "volume-curve.png")
    yield from window.picture(out / "volume-curve-sidebar.png", window.region(window.area("VIEW_3D"), "UI"))
    closed(panel)
    image = bpy.data.images["Ball Volume"]
    image.save(filepath=str(out / "volume-curve-image.png"))


def menu(out: Path) -> window.Steps:
    """All that can be done, in the Object menu's place; Esc closes it again."""
    view, main_window = window.area("VIEW_3D"), bpy.context.window_manager.windows[0]
    place = (view.x + 130, view.y + view.height // 2 + 60)
    main_window.cursor_warp(*place)
    yield from window.settle()
    with window.within(view):
        bpy.ops.wm.call_menu(name="VIEW3D_MT_isochor")
    yield from window.picture(out / "menu.png", view)
    for value in ("PRESS", "RELEASE"):
        main_window.event_simulate(type="ESC", value=value, x=place[0], y=place[1])
        yield


def popover(out: Path) -> window.Steps:
    """The overlay's place among Blender's own. The popover stays open, so this is the last picture."""
    view = window.area("VIEW_3D")
    bpy.context.window_manager.windows[0].cursor_warp(view.x + view.width - 330, view.y + view.height - 60)
    yield from window.settle()
    with window.within(view, "HEADER"):
        bpy.ops.wm.call_panel(name="VIEW3D_PT_overlay", keep_open=True)
    yield from window.picture(out / "overlays-popover.png")


def everything(out: Path) -> window.Steps:
    """All pictures, one after the other."""
    yield from set_up_window()
    shading()
    for part in (just_added, squashed, deformed_space, folded, animated, volume_curve, menu, popover):
        yield from part(out)
    complaints = sys.modules[f"{EXTENSION}.tool.overlay"].complaints()
    if complaints:
        raise RuntimeError(f"the overlay could not always be drawn: {complaints}")


if __name__ == "__main__":
    window.main(__doc__.splitlines()[0], everything)
