# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pages on all of free-form deformation, as they are set up for a render, without one: every volume that
a picture promises, and what its caption says, measured on the mesh that Blender evaluates."""

import importlib
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils.kdtree import KDTree

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon" / "demo"), str(ROOT / "blend_fixtures")]

from models.elephant import make_elephant  # noqa: E402
from models.model import Model  # noqa: E402
from patch_object import patch_surface  # noqa: E402
from render_gallery import measured  # noqa: E402
from surface_measures import enclosed_volume, mesh_arrays  # noqa: E402

EXACT = 1e-6
"""Relative error of a volume on vertices in float32."""


def page(name):
    return importlib.import_module(f"pages.{name}")


def walked(name):
    """The page's tiles, each measured as it is set up; every promised volume is exact."""
    found = []
    for tile in page(name).tiles(bpy.context.scene):
        volume = measured(tile)
        assert tile.must_be is None or abs(volume / tile.must_be - 1.0) <= EXACT, tile
        found.append((tile, volume))
    return found


@pytest.mark.parametrize("level", [1, 2, 5])
def test_the_patch_model_is_watertight_at_every_level(level):
    elephant = make_elephant()
    found = elephant.tessellate(level)
    model = Model(found.vertices, found.triangles)
    assert len(elephant.patches) >= 32
    assert model.is_closed
    assert model.genus == 0
    assert enclosed_volume(found.vertices, found.triangles) > 3.0
    sides = found.vertices[found.triangles]
    areas = np.linalg.norm(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1)
    assert areas.min() > 1e-6


def test_the_patch_model_is_smooth_across_its_edges():
    elephant = make_elephant()
    along = np.linspace(0.0, 1.0, 9)
    zero, one = np.zeros(9), np.ones(9)
    ends = (along, zero), (one, along), (1.0 - along, one), (zero, 1.0 - along)
    normals = [elephant.normals(*end) for end in ends]
    sides = {}
    for number, patch in enumerate(elephant.patches):
        for edge in range(4):
            sides[tuple(np.rot90(patch, edge)[0].tolist())] = normals[edge][number]
    assert len(sides) == 4 * len(elephant.patches)
    alike = [(side * sides[row[::-1]][::-1]).sum(axis=1).min() for row, side in sides.items()]
    turns = np.arccos(np.clip(alike, -1.0, 1.0))
    assert np.degrees(max(turns)) < 1.5
    assert np.degrees(np.mean(turns)) < 0.1


def test_blenders_own_surface_of_the_patch_model_is_the_same():
    elephant = make_elephant()
    surface = patch_surface("Elephant", elephant, resolution=2)
    assert {(spline.point_count_u, spline.order_v) for spline in surface.data.splines} == {(4, 4)}
    drawn = surface.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    points, triangles = mesh_arrays(drawn)
    ours = elephant.tessellate(7)
    tree = KDTree(len(points))
    for number, place in enumerate(points):
        tree.insert(place, number)
    tree.balance()
    assert max(tree.find(place)[2] for place in ours.vertices) < 1e-5
    assert enclosed_volume(points, triangles) == pytest.approx(enclosed_volume(ours.vertices, ours.triangles), rel=1e-5)


def test_boxes_lean_with_the_object_and_degrees_move_as_powers():
    degrees = page("degrees")
    assert len(walked("degrees")) == 6
    large, small = (degrees.box_share(degrees.leaning(bpy.context.scene, fit)) for fit, _ in degrees.BOXES)
    assert small < 1.2 < 3.0 < large
    for layers in degrees.DEGREES:
        staged = degrees.dragged(bpy.context.scene, layers)
        # The drag's share at half height is (1/2)^degree: the last Bernstein polynomial.
        assert degrees.moved_halfway(staged) == pytest.approx(0.5 ** (layers - 1), abs=1e-3)


def test_flat_letters_keep_their_area():
    shown = walked("flat")
    plain = [volume / tile.whole for tile, volume in shown if tile.must_be is None]
    assert len(plain) == 1
    assert plain[0] > 1.2


def test_poses_are_blended_and_keep_the_volume():
    poses = page("poses")
    assert len(walked("poses")) == len(poses.MIXES)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    staged = poses.posed(bpy.context.scene)
    staged.put(Preserve=0.0)
    shapes = []
    for values in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.6, 0.7)):
        poses.mix(staged, values)
        seen = staged.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        shapes.append(mesh_arrays(seen.data)[0].astype(np.float64))
    rest, *single, mixed = shapes
    blended = rest + sum(value * (shape - rest) for value, shape in zip((0.5, 0.6, 0.7), single, strict=True))
    assert np.abs(mixed - blended).max() < 1e-5


def middle(obj):
    """Of the points that Blender draws, in the object's own space."""
    geometry = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    drawn = next(data for data in (geometry.mesh, geometry.curves, geometry.pointcloud) if data is not None)
    values = drawn.attributes["position"].data
    places = np.empty(3 * len(values), np.float32)
    values.foreach_get("vector", places)
    return places.reshape(-1, 3).mean(axis=0)


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Python makes no point cloud in this Blender")
def test_a_row_of_all_kinds_is_bent_over_a_hill_and_the_text_keeps_its_volume():
    kinds = page("kinds")
    assert len(walked("kinds")) == 2
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    objects = kinds.row(bpy.context.scene)
    lattice = kinds.wrapped(objects)
    before = [middle(obj) for obj in objects]
    kinds.bend(lattice)
    for obj, was in zip(objects, before, strict=True):
        moved = obj.matrix_world.to_3x3() @ type(obj.location)(middle(obj) - was)
        assert abs(moved.x) > 0.1 or moved.z > 0.5, obj.name


def test_only_the_patch_models_control_points_move_and_its_tessellation_keeps_the_volume():
    (_, _), (alone, plain), (kept, _) = walked("patches")
    assert alone.must_be is None
    assert plain < 0.8 * kept.whole
    deformed = page("patches").PatchDeformation()
    surface, points, _ = deformed.shaped(1.0)
    assert np.abs(deformed.surface.apply(points) - surface).max() < 1e-12
    assert enclosed_volume(surface, deformed.triangles) == pytest.approx(deformed.whole, rel=1e-12)


def test_a_native_lattice_is_converted_without_change_and_then_keeps_the_volume():
    converted = page("converted")
    (_, before), (_, after), (kept, _) = walked("converted")
    assert before < 0.8 * kept.whole
    assert after == pytest.approx(before, rel=1e-5)
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "blend_fixtures" / "native_lattice.blend"))
    elephant, frames = bpy.data.objects["Elephant"], (1, 7, 12, 24)
    shapes = []
    for convert in (False, True):
        if convert:
            converted.convert(elephant)
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            shapes.append(converted.evaluated_points(elephant))
    assert [modifier.type for modifier in elephant.modifiers] == ["NODES"]
    moved = [converted.difference(shape, shapes[0]) for shape in shapes[:4]]
    assert moved[0] == 0.0
    assert min(moved[1:]) > 0.05
    assert max(map(converted.difference, shapes[4:], shapes[:4])) <= 1e-6


def test_refinement_changes_nothing_and_the_finer_lattice_makes_a_detail():
    refined = page("refined")
    assert len(walked("refined")) == 3
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    staged = refined.posed(bpy.context.scene)
    assert refined.refined_apart(staged) <= 1e-6
    data = staged.lattice.data
    assert (data.points_u, data.points_v, data.points_w) == refined.FINER
    assert [key.name for key in data.shape_keys.key_blocks] == ["Basis", "Wave", "Twist"]
    before = refined.evaluated_points(staged.object)
    refined.bulge(staged)
    moved = np.linalg.norm(refined.evaluated_points(staged.object) - before, axis=1)
    assert moved.max() > 0.1


def test_adaptive_faces_are_few_and_keep_volume_and_materials():
    (_, _), (few, _), (_, _) = walked("adaptive")
    adaptive = page("adaptive")
    faces = {}
    for parts in (1, adaptive.EVEN):
        faces[parts] = len(adaptive.bent(bpy.context.scene, parts).object.data.polygons)
    staged = adaptive.bent(bpy.context.scene)
    adaptive.apply(staged.object, adaptive.TOLERANCE)
    mesh = staged.object.data
    assert few.note == f"{len(mesh.polygons)} faces"
    assert faces[1] < len(mesh.polygons) < faces[adaptive.EVEN]
    upper = {polygon.material_index for polygon in mesh.polygons if polygon.center.x > 0.4}
    assert upper == {1}
    assert {polygon.material_index for polygon in mesh.polygons} == {0, 1}


@pytest.mark.parametrize(("joint", "torn", "turn"), [("Free", True, None), ("C0", False, 5.0), ("C1", False, 1.5)])
def test_joints_are_as_smooth_as_they_say(joint, torn, turn):
    joints = page("joints")
    staged = joints.half_held(bpy.context.scene)
    staged.put(Outside="Keep", Joint=joint)
    step, angle = joints.jumps(staged)
    assert (step > 0.1) is torn
    if turn:
        assert (angle > turn) is (joint == "C0")


def test_every_joint_keeps_the_volume():
    assert len(walked("joints")) == len(page("joints").CASES)


def test_a_heavier_point_pulls_harder_and_weights_make_an_exact_circle():
    weights = page("weights")
    assert len(walked("weights")) == 6
    lifts = [weights.lift(weights.pulled(bpy.context.scene, weight)) for weight in weights.WEIGHTS]
    assert lifts == sorted(lifts)
    assert lifts[-1] > 2.0 * lifts[0]
    off = [weights.off_circle(weights.bent_bar(bpy.context.scene, weight)) for weight in (1.0, weights.LIGHT)]
    assert off[0] > 0.1
    assert off[1] <= 2e-6  # of coordinates up to 2 in float32
