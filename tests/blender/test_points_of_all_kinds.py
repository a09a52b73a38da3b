# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves, hair, point clouds and texts through the modifier: the same deformation as an independent evaluation, live,
rendered, saved, undone."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
import things
from test_deformation import bent


def two_curves():
    """A Bézier curve, a NURBS one and a straight one in one object."""
    obj = things.curve("BEZIER", things.path(4))
    things.add_spline(obj.data, "NURBS", things.path(6)[:, [1, 0, 2]])
    things.add_spline(obj.data, "POLY", things.path(3)[:, [2, 1, 0]])
    return obj


MAKERS = {
    "bezier": lambda: things.curve("BEZIER", things.path(5), cyclic=True),
    "nurbs": lambda: things.curve("NURBS", things.path(7)),
    "several": two_curves,
    "hair": things.hair,
    "cloud": things.cloud,
    "text": things.text,
}


@pytest.fixture(params=MAKERS)
def made(request):
    scenes.empty_file()
    obj = MAKERS[request.param]()
    obj.location, obj.rotation_euler, obj.scale = (0.4, -0.3, 0.2), (0.3, 0.2, -0.5), (1.1, 0.9, 1.0)
    bpy.context.view_layer.update()
    return obj


def kept(obj, name, depsgraph=None):
    """Which of the points shown mean something: of handles, those of Bézier curves."""
    holder = obj.evaluated_get(depsgraph or bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    if not name.startswith("handle"):
        return slice(None)
    sizes = [len(curve.points) for curve in holder.curves.curves]
    return np.repeat(things.numbers(holder.curves, "curve_type") == 2, sizes)


def largest(one, other, obj):
    """The largest distance between what two readings show of an object, along an axis."""
    assert one.keys() == other.keys()
    return max(np.abs(one[name] - other[name])[kept(obj, name)].max() for name in one)


def expected(obj, lattice, before):
    return {name: lattice_oracle.deformed(obj, lattice, points, "Bernstein") for name, points in before.items()}


def test_every_kind_is_deformed_as_numpy_says_and_says_that_nothing_is_wrong(made):
    before = things.shown(made)
    lattice = scenes.lattice_object(4, size=6.0)
    bent(lattice)
    modifier = scenes.volume_lattice(made, lattice, Preserve=0.0 if made.type == "FONT" else 1.0)
    after = things.shown(made)
    assert largest(after, expected(made, lattice, before), made) < 2e-6
    assert largest(after, before, made) > 0.05
    report = scenes.report(made, modifier)
    assert not report.problems
    assert report.has_surface == (made.type == "FONT")
    assert report.notes == ([] if report.has_surface else [scenes.part("core.problem").NO_SURFACE])


def test_the_lattice_fits_and_is_taken_away_in_one_step_each(made):
    before = things.shown(made)
    bpy.ops.ed.undo_push(message="start")
    assert bpy.ops.isochor.add("EXEC_DEFAULT", True) == {"FINISHED"}
    modifier = made.modifiers[0]
    assert scenes.report(made, modifier).vertices_outside == 0
    assert largest(things.shown(made), before, made) < 2e-6
    bpy.ops.ed.undo()
    made = bpy.context.object
    assert not made.modifiers
    assert not bpy.data.lattices
    bpy.ops.isochor.add("EXEC_DEFAULT", True)
    bent(scenes.get_input(made.modifiers[0], "Lattice"))
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not made.modifiers
    assert not bpy.data.lattices
    assert not bpy.data.node_groups
    assert largest(things.shown(made), before, made) == 0.0


def keyed_lattice():
    """Bent in frame 10, undeformed in frame 1."""
    lattice = scenes.lattice_object(4, size=6.0)
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Bent")
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.3 * z, y + 0.2 * x, z - 0.4 * y * y)
    for frame in (1, 10):
        key.value = float(frame == 10)
        key.keyframe_insert("value", frame=frame)
    return lattice


class Watching(bpy.types.RenderEngine):
    """Instead of a picture it notes what a render engine gets, between frames too."""

    bl_idname = "ISOCHOR_WATCHING"
    bl_label = "Watching"
    noted: list = []

    def render(self, depsgraph):
        for subframe in (0.0, 0.5):
            self.frame_set(depsgraph.scene.frame_current, subframe=subframe)
            self.noted.append(things.shown(bpy.context.scene.objects[0], depsgraph))


def test_renders_play_and_reload(made, tmp_path):
    before, scene = things.shown(made), bpy.context.scene
    lattice = keyed_lattice()
    scenes.volume_lattice(made, lattice, Preserve=0.0)
    scene.frame_set(10)
    bent_shape = things.shown(made)
    assert largest(bent_shape, expected(made, lattice, before), made) < 2e-6
    assert largest(bent_shape, before, made) > 0.05
    scene.frame_set(1)
    assert largest(things.shown(made), before, made) < 2e-6
    bpy.utils.register_class(Watching)
    try:
        Watching.noted.clear()
        scene.render.engine, scene.frame_start, scene.frame_end = "ISOCHOR_WATCHING", 9, 10
        scene.collection.objects.link(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
        scene.camera = bpy.data.objects["Camera"]
        bpy.ops.render.render(animation=True)
    finally:
        bpy.utils.unregister_class(Watching)
    scene.render.engine = "CYCLES"
    scene.frame_set(9, subframe=0.5)
    assert largest(Watching.noted[1], things.shown(made), made) < 2e-6
    assert largest(Watching.noted[2], bent_shape, made) < 2e-6
    scene.frame_set(10)
    name = made.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    made = bpy.data.objects[name]
    assert largest(things.shown(made), bent_shape, made) < 2e-6
    bpy.context.scene.frame_set(1)
    assert largest(things.shown(made), before, made) < 2e-6


def test_rest_can_be_set_and_the_lattice_fitted_again(made):
    before = things.shown(made)
    lattice = scenes.lattice_object(3, size=6.0)
    scenes.volume_lattice(made, lattice, Preserve=0.0)
    scenes.choose(made)
    assert bpy.ops.isochor.set_rest() == {"FINISHED"}
    lattice.location.x += 0.25
    bpy.context.view_layer.update()
    step = np.array(made.matrix_world.inverted().to_3x3()) @ (0.25, 0.0, 0.0)
    assert largest(things.shown(made), {name: points + step for name, points in before.items()}, made) < 3e-6
    assert bpy.ops.isochor.clear_rest() == {"FINISHED"}
    assert bpy.ops.isochor.fit_lattice() == {"FINISHED"}
    assert largest(things.shown(made), before, made) < 3e-6
    assert scenes.report(made, made.modifiers[0]).vertices_outside == 0


@pytest.mark.parametrize("operator", ["bake", "apply", "add_pin"])
def test_what_works_on_meshes_only_says_so(made, operator):
    scenes.volume_lattice(made, scenes.lattice_object(4, size=6.0), Preserve=0.0)
    scenes.choose(made)
    with pytest.raises(RuntimeError, match="works on meshes: convert it first"):
        getattr(bpy.ops.isochor, operator)("EXEC_DEFAULT")
    assert len(made.modifiers) == 1
