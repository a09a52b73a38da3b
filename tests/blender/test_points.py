# SPDX-License-Identifier: GPL-3.0-or-later
"""Control points of surfaces, curves and lattices, deformed by an operator: where they go, the volume, the way back."""

import bpy
import lattice_oracle
import numpy as np
import pytest
import scenes
import things
from test_deformation import bent


def surface(kind="sphere"):
    getattr(bpy.ops.surface, f"primitive_nurbs_surface_{kind}_add")()
    return bpy.context.object


def target_lattice():
    lattice = scenes.lattice_object((3, 2, 4), name="Inner", size=1.5)
    bpy.context.view_layer.update()
    return lattice


def weighted_curve():
    obj = things.curve("BEZIER", things.path(4))
    obj.data.splines[0].bezier_points[1].handle_left_type = "AUTO"
    things.add_spline(obj.data, "NURBS", things.path(5)[:, [1, 0, 2]])
    return obj


MAKERS = {"surface": surface, "lattice": target_lattice, "curve": weighted_curve}


@pytest.fixture(params=MAKERS)
def made(request):
    """The object to deform and a bent lattice around it, active."""
    scenes.empty_file()
    obj = MAKERS[request.param]()
    obj.location, obj.rotation_euler, obj.scale = (0.4, -0.3, 0.2), (0.3, 0.2, -0.5), (1.1, 0.9, 1.0)
    lattice = scenes.lattice_object(4, name="Outer", size=6.0)
    bpy.context.view_layer.update()
    bent(lattice)
    choose(obj, lattice)
    return obj, lattice


def choose(obj, lattice):
    scenes.choose(lattice)
    obj.select_set(True)
    bpy.context.view_layer.update()


def read(obj):
    return scenes.part("tool.control_points").read(obj.data)


def everything(obj):
    """All that the points hold, to the bit."""
    data = obj.data
    if obj.type == "LATTICE":
        return [tuple(point.co_deform) for point in data.points]
    return [
        (spline.type, spline.order_u, spline.resolution_u)
        + tuple(tuple(point.co) for point in spline.points)
        + tuple(
            (tuple(p.co), tuple(p.handle_left), tuple(p.handle_right), p.handle_left_type, p.handle_right_type)
            for p in spline.bezier_points
        )
        for spline in data.splines
    ]


def test_points_become_what_numpy_says_and_come_back_exactly(made):
    obj, lattice = made
    before, all_before, name = read(obj), everything(obj), obj.data.name
    bpy.ops.ed.undo_push(message="start")
    assert bpy.ops.isochor.deform_points("EXEC_DEFAULT", True, preserve=0.0) == {"FINISHED"}
    wanted = lattice_oracle.deformed(obj, lattice, before, "Bernstein")
    assert np.abs(read(obj) - wanted).max() < 2e-6
    assert np.abs(read(obj) - before).max() > 0.05
    shown = things.shown(obj) if obj.type != "LATTICE" else {}
    assert bpy.ops.isochor.deform_points(preserve=0.0) == {"FINISHED"}
    assert np.abs(read(obj) - wanted).max() < 2e-6
    for kind, points in (things.shown(obj) if shown else {}).items():
        assert np.abs(points - shown[kind]).max() == 0.0
    assert bpy.ops.isochor.restore_points() == {"FINISHED"}
    assert everything(obj) == all_before
    assert obj.data.name == name
    assert not [data for data in (*bpy.data.curves, *bpy.data.lattices) if "Deformed" in data.name]


def test_it_is_one_step_of_undo(made):
    obj, _lattice = made
    before, name = everything(obj), obj.name
    bpy.ops.ed.undo_push(message="start")
    assert bpy.ops.isochor.deform_points("EXEC_DEFAULT", True) == {"FINISHED"}
    assert everything(obj) != before
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    assert everything(obj) == before
    assert not scenes.part("tool.point_rest").is_deformed(obj)
    bpy.ops.ed.redo()
    obj = bpy.data.objects[name]
    assert everything(obj) != before
    choose(obj, bpy.data.objects["Outer"])
    assert bpy.ops.isochor.restore_points() == {"FINISHED"}
    assert everything(obj) == before


def test_strength_and_points_outside(made):
    obj, lattice = made
    before = read(obj)
    bpy.ops.isochor.deform_points(preserve=0.0)
    full = read(obj)
    bpy.ops.isochor.deform_points(preserve=0.0, strength=0.25)
    assert np.abs(read(obj) - (before + 0.25 * (full - before))).max() < 2e-6
    lattice.scale = (1.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    bpy.ops.isochor.deform_points(preserve=0.0, outside="KEEP")
    still = (np.abs(read(obj) - before) < 1e-7).all(axis=1)
    assert still.any()
    bpy.ops.isochor.deform_points(preserve=0.0, outside="EXTEND")
    assert (np.abs(read(obj) - before)[still] > 1e-3).any()


def test_the_rest_survives_saving_and_what_was_edited_since_is_not_lost_silently(made, tmp_path):
    obj, _lattice = made
    before, name = everything(obj), obj.name
    bpy.ops.isochor.deform_points(preserve=0.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "points.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "points.blend"))
    obj, lattice = bpy.data.objects[name], bpy.data.objects["Outer"]
    choose(obj, lattice)
    moved = read(obj)
    scenes.part("tool.control_points").write(obj.data, moved + 0.125)
    with pytest.raises(RuntimeError, match="were edited after they had been deformed"):
        bpy.ops.isochor.deform_points(preserve=0.0)
    assert np.abs(read(obj) - moved - 0.125).max() < 1e-6
    bpy.ops.isochor.restore_points()
    assert everything(obj) == before
    bpy.ops.isochor.deform_points(preserve=0.0)
    assert np.abs(read(obj) - moved).max() < 2e-6
    assert bpy.ops.isochor.deform_points(preserve=0.0, anew=True) == {"FINISHED"}
    assert np.abs(read(obj) - moved).max() > 1e-3
    bpy.ops.isochor.restore_points()
    assert np.abs(read(obj) - moved).max() < 2e-6


def test_a_shape_made_by_keys_is_what_gets_deformed(made):
    obj, lattice = made
    points = read(obj)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Moved", from_mix=False)
    scenes.part("tool.control_points").write_key(obj.data, key, points + 0.1)
    key.value = 0.5
    bpy.context.view_layer.update()
    assert bpy.ops.isochor.deform_points(preserve=0.0) == {"FINISHED"}
    wanted = lattice_oracle.deformed(obj, lattice, points + 0.05, "Bernstein")
    assert np.abs(read(obj) - wanted).max() < 2e-6
    assert obj.data.shape_keys is None
    bpy.ops.isochor.restore_points()
    assert [block.name for block in obj.data.shape_keys.key_blocks] == ["Basis", "Moved"]


def test_other_objects_that_share_the_points_keep_theirs(made):
    obj, _lattice = made
    twin = bpy.data.objects.new("Twin", obj.data)
    bpy.context.scene.collection.objects.link(twin)
    before = everything(twin)
    bpy.ops.isochor.deform_points(preserve=0.0)
    assert everything(twin) == before
    assert everything(obj) != before


@pytest.mark.parametrize("kind", ["sphere", "torus"])
@pytest.mark.parametrize("basis", ["BERNSTEIN", "BSPLINE"])
def test_a_closed_surface_keeps_its_volume_by_its_control_points_alone(kind, basis):
    obj = surface(kind)
    obj.rotation_euler = (0.3, 0.2, -0.5)
    lattice = scenes.lattice_object((6, 6, 7), size=9.0) if basis == "BSPLINE" else scenes.lattice_object(4, size=6.0)
    bpy.context.view_layer.update()
    before = enclosed(obj)
    for point in lattice.data.points:
        point.co_deform = np.array(point.co_deform) * (0.6, 1.0, 0.8) + (0.2 * point.co.y**2, 0.0, 0.0)
    choose(obj, lattice)
    assert bpy.ops.isochor.deform_points(basis=basis, preserve=0.0) == {"FINISHED"}
    assert abs(enclosed(obj) / before - 1.0) > 0.1
    assert bpy.ops.isochor.deform_points(basis=basis) == {"FINISHED"}
    assert abs(enclosed(obj) / before - 1.0) < 1e-6
    exact = kept_in_float64(obj, lattice, basis)
    assert abs(exact.target / before - 1.0) < 1e-6
    assert abs(exact.volume / exact.target - 1.0) < 1e-12
    assert bpy.ops.isochor.deform_points(basis=basis, target=1.25) == {"FINISHED"}
    assert abs(enclosed(obj) / (1.25 * before) - 1.0) < 1e-6


def enclosed(obj):
    """Volume in float64 of the mesh that Blender makes, over its quads, each cut at the corner where ours are."""
    holder = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    points = things.vectors(holder.mesh, "position")
    (patch,) = scenes.part("tool.control_points").patches(obj.data)
    quads = scenes.part("core.nurbs").surface(patch.u, patch.v, patch.weights).quads
    drawn = [sorted(face.vertices) for face in holder.mesh.polygons]
    assert sorted(drawn) == sorted(map(sorted, quads.tolist()))
    a, b, c = points[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def kept_in_float64(obj, lattice, basis):
    """What the operator computed, before Blender rounded it to float32: once more from the points at rest."""
    deforming, settings = scenes.part("tool.deforming_points"), scenes.part("core.settings")
    name = {"BERNSTEIN": "Bernstein", "BSPLINE": "B-Spline"}[basis]
    bpy.ops.isochor.restore_points()
    bpy.context.view_layer.update()
    points = read(obj)
    deformer = deforming.Deformer(lattice, settings.Settings(basis=name))
    found = deforming.deformed(
        obj, points, deforming.shell_of(obj, points), deformer, bpy.context.evaluated_depsgraph_get()
    )
    bpy.ops.isochor.deform_points(basis=basis)
    assert np.abs(read(obj) - found.points).max() < 1e-6
    return found


def test_an_open_surface_says_so_and_keeps_a_volume_with_its_holes_closed():
    obj = surface("cylinder")
    lattice = scenes.lattice_object(4, size=6.0)
    bent(lattice)
    choose(obj, lattice)
    assert bpy.ops.isochor.deform_points() == {"FINISHED"}
    without = read(obj)
    assert bpy.ops.isochor.deform_points(close_holes=True) == {"FINISHED"}
    assert np.abs(read(obj) - without).max() > 1e-3


def test_what_cannot_be_deformed_says_why():
    ball = scenes.sphere()
    assert not bpy.ops.isochor.deform_points.poll()
    lattice = scenes.lattice_object(4, name="Alone")
    scenes.choose(lattice)
    with pytest.raises(RuntimeError, match="last the lattice"):
        bpy.ops.isochor.deform_points()
    obj = surface()
    with pytest.raises(RuntimeError, match="Select last the lattice"):
        bpy.ops.isochor.deform_points()
    assert bpy.ops.isochor.deform_points(lattice="Alone") == {"FINISHED"}
    assert ball.modifiers.keys() == []
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Edit Mode"):
        bpy.ops.isochor.deform_points(lattice="Alone")
    with pytest.raises(RuntimeError, match="Edit Mode"):
        bpy.ops.isochor.restore_points()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert obj.data is not None
    bpy.ops.object.metaball_add()
    scenes.choose(bpy.context.object)
    with pytest.raises(RuntimeError, match="Metaballs have no points"):
        bpy.ops.isochor.deform_points()


@pytest.mark.parametrize("kind", ["surface", "lattice", "metaball"])
def test_blender_lets_no_such_modifier_onto_these_and_adding_says_so(kind):
    if kind == "metaball":
        bpy.ops.object.metaball_add()
    elif kind == "lattice":
        scenes.choose(target_lattice())
    else:
        surface()
    assert bpy.context.object.modifiers.new("Try", "NODES") is None
    with pytest.raises(RuntimeError, match="there is Deform Points"):
        bpy.ops.isochor.add()


@pytest.mark.parametrize("kind", ["KEY_LINEAR", "KEY_CARDINAL", "KEY_CATMULL_ROM", "KEY_BSPLINE"])
def test_with_the_basis_blender_points_go_where_its_own_modifier_takes_them(made, kind):
    obj, lattice = made
    for name in ("interpolation_type_u", "interpolation_type_v", "interpolation_type_w"):
        setattr(lattice.data, name, kind)
    # Its control points, not the mesh that Blender makes of them.
    scenes.native_lattice(obj, lattice).use_apply_on_spline = True
    bpy.context.view_layer.update()
    wanted = seen(obj)
    obj.modifiers.clear()
    assert bpy.ops.isochor.deform_points(basis="BLENDER", outside="EXTEND", preserve=0.0) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert np.abs(seen(obj) - wanted).max() < 5e-6


def seen(obj):
    """What Blender evaluates: points of a lattice, else all that is drawn."""
    if obj.type != "LATTICE":
        return np.concatenate([points for name, points in things.shown(obj).items() if "handle" not in name])
    held = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([tuple(point.co_deform) for point in held.data.points], np.float64)
