# SPDX-License-Identifier: GPL-3.0-or-later
"""When to compute: after Blender has evaluated a frame or an edit, before it draws or renders it.

Blender evaluates once more within the same frame change or update what a handler has written, without calling the
handlers again.
"""

import bpy
from bpy.app.handlers import persistent

import isochor

from . import mixed_up, node_group, rest, stack, state, tie_settling


@persistent
def frame_changed(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """A new frame or sub-frame, in playback and in renders: every object of ours that this depsgraph has."""
    state.refresh(stack.users(node_group.all_groups()), depsgraph)


@persistent
def depsgraph_updated(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """An edit of a lattice, a mesh, a socket, a transform: the objects that it reaches."""
    state.refresh(state.updated_users(depsgraph, tie_settling.settle(depsgraph)), depsgraph)
    _redraw_sidebars(depsgraph)


@persistent
def data_about_to_be_replaced(*_arguments: object) -> None:
    """An undo or redo comes."""
    mixed_up.note()


@persistent
def data_replaced(*_arguments: object) -> None:
    """An undo or redo: what is remembered belongs to data that is gone."""
    state.clear()
    mixed_up.put_right()


@persistent
def file_about_to_be_saved(*_arguments: object) -> None:
    """What every process that renders the file must agree on goes into it."""
    rest.measure_missing(bpy.context.view_layer)


@persistent
def file_loaded(*_arguments: object) -> None:
    """Another file: forget the old one, make its node groups fit this Blender, and have its objects computed with the
    first update, since the library of a linked one may have changed."""
    mixed_up.forget()
    node_group.rebuild_foreign()
    if node_group.all_groups():
        # Blender would not tell of tags that it meets in its first evaluation of a file.
        bpy.context.view_layer.update()
    recompute()


def recompute() -> None:
    """Has every object of ours evaluated anew, with nothing remembered."""
    state.start_file()
    for obj in stack.users(node_group.all_groups()):
        obj.update_tag(refresh={"DATA"})


HANDLERS = (
    ("frame_change_post", frame_changed),
    ("depsgraph_update_post", depsgraph_updated),
    ("undo_pre", data_about_to_be_replaced),
    ("redo_pre", data_about_to_be_replaced),
    ("undo_post", data_replaced),
    ("redo_post", data_replaced),
    ("load_post", file_loaded),
    ("save_pre", file_about_to_be_saved),
)


def register() -> None:
    """Hangs the handlers into Blender."""
    state.start_file()
    # Jobs of a farm must give the same frames to the bit, however many each has computed before.
    isochor.prepare_in_background(not bpy.app.background)
    for event, handler in HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    """Takes them out again, last first."""
    for event, handler in reversed(HANDLERS):
        getattr(bpy.app.handlers, event).remove(handler)
    state.clear()


def _redraw_sidebars(depsgraph: bpy.types.Depsgraph) -> None:
    if bpy.app.background or depsgraph.mode != "VIEWPORT":
        return
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()
