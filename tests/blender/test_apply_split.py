# SPDX-License-Identifier: GPL-3.0-or-later
"""isochor.apply with a tolerance: faces are split where space bends, without cracks, and what they carry survives."""

from collections import Counter

import bpy
import numpy as np
import pytest
import scenes

CORNERS = [(x, y, z) for z in (-3, 3) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
TOLERANCE = 0.01


def bar(faces=FACES, bend: float = 1.6, **inputs) -> tuple[bpy.types.Object, bpy.types.NodesModifier]:
    """A box with one face a side, bent by its lattice."""
    obj = scenes.mesh_object("Bar", CORNERS, faces)
    modifier = scenes.volume_lattice(obj, scenes.lattice_object((2, 2, 7), size=1.0), **inputs)
    lattice = scenes.get_input(modifier, "Lattice")
    lattice.scale = (1.4, 1.4, 6.6)
    scenes.set_input(modifier, "Bend", bend)
    bpy.context.view_layer.update()
    return obj, modifier


def borders(mesh: bpy.types.Mesh) -> set[int]:
    """In how many faces edges lie."""
    found = Counter(key for polygon in mesh.polygons for key in polygon.edge_keys)
    return set(found.values())


def applied(obj: bpy.types.Object, **properties) -> None:
    scenes.choose(obj)
    assert bpy.ops.isochor.apply(tolerance=TOLERANCE, **properties) == {"FINISHED"}


def corners(obj: bpy.types.Object, name: str) -> np.ndarray:
    """(E, 2, 3) ends of every edge as a shape key has them."""
    points = np.array([tuple(point.co) for point in obj.data.shape_keys.key_blocks[name].points])
    return points[[tuple(edge.vertices) for edge in obj.data.edges]]


def deviation(rest: np.ndarray, deformed: np.ndarray, lattice, control: np.ndarray) -> float:
    """How far middles of edges (E, 2, 3) go from the straight edges between their deformed ends."""
    middle = np.asarray(lattice.evaluate(lattice.parameters(rest.mean(axis=1)), control))
    start, way = deformed[:, 0], deformed[:, 1] - deformed[:, 0]
    along = np.einsum("ij,ij->i", middle - start, way) / np.einsum("ij,ij->i", way, way)
    return float(np.linalg.norm(middle - start - along[:, None] * way, axis=1).max())


@pytest.mark.parametrize("preserve", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["quads", "triangles"])
def test_a_plain_box_bends_into_a_smooth_arc(kind, preserve):
    faces = FACES if kind == "quads" else [half for a, b, c, d in FACES for half in ((a, b, c), (a, c, d))]
    obj, modifier = bar(faces, Preserve=preserve)
    whole, modifier_name = scenes.volume(obj.data), modifier.name
    report = scenes.report(obj, modifier)
    lattice, control = scenes.part("core.grid").build_lattice(report.grid), np.asarray(report.control)
    applied(obj, as_shape_key=True)
    mesh = obj.data
    assert not obj.modifiers
    assert 40 < len(mesh.vertices) < 1500
    assert borders(mesh) == {2}
    rest, shape = corners(obj, "Basis"), corners(obj, modifier_name)
    if preserve:
        assert abs(scenes.evaluated_volume(obj) / whole - 1) <= 1e-6
    else:
        assert 0.001 < deviation(rest, shape, lattice, control) <= TOLERANCE
    assert np.abs(np.unique(rest) - np.round(np.unique(rest) * 512) / 512).max() < 1e-6
    assert not [found.name for found in mesh.attributes if "isochor" in found.name]
    assert not [found for found in bpy.data.meshes if found.name.startswith(".")]


def test_only_where_it_has_to_be():
    obj, _modifier = bar(bend=0.0, Preserve=0.0)
    applied(obj)
    assert len(obj.data.vertices) == 8
    long, _modifier = bar(bend=2.5)
    applied(long)
    points = scenes.positions(long.data)
    assert len(points) > 60
    across = [np.ptp(points[list(edge.vertices)], axis=0).max() for edge in long.data.edges]
    assert max(across) > 0.5


def test_materials_uvs_colours_groups_and_seams_survive():
    obj, _modifier = bar()
    mesh = obj.data
    for name in ("Side", "Cap"):
        mesh.materials.append(bpy.data.materials.new(name))
    for polygon in mesh.polygons:
        polygon.material_index, polygon.use_smooth = int(polygon.index < 2), polygon.index > 1
    # Mapped by height, so that wherever a corner comes to lie, its coordinates say.
    mesh.uv_layers.new(name="Map")
    mesh.color_attributes.new("Colour", "FLOAT_COLOR", "CORNER")
    uv, height = mesh.uv_layers["Map"], mesh.color_attributes["Colour"]
    for loop in mesh.loops:
        x, y, z = mesh.vertices[loop.vertex_index].co
        uv.data[loop.index].uv = ((z + 3) / 6, x + y)
        height.data[loop.index].color = ((z + 3) / 6, x + 0.5, y + 0.5, 1.0)
    group = obj.vertex_groups.new(name="Height")
    for vertex in mesh.vertices:
        group.add([vertex.index], (vertex.co.z + 3) / 6, "REPLACE")
    for edge in mesh.edges:
        edge.use_seam = edge.use_edge_sharp = bool(np.ptp([mesh.vertices[v].co.z for v in edge.vertices]) > 1)
    seams = sum(edge.use_seam for edge in mesh.edges)
    bpy.context.view_layer.update()
    applied(obj, as_shape_key=True)
    mesh = obj.data
    rest = np.array([tuple(point.co) for point in mesh.shape_keys.reference_key.points])
    assert len(rest) > 40
    assert mesh.materials.keys() == ["Side", "Cap"]
    assert {(polygon.material_index, polygon.use_smooth) for polygon in mesh.polygons} == {(0, True), (1, False)}
    caps = [p for p in mesh.polygons if p.material_index == 1]
    assert all(np.ptp(rest[list(p.vertices)][:, 2]) < 1e-6 for p in caps)
    mapping, colours = mesh.uv_layers["Map"].data, mesh.attributes["Colour"].data
    for loop, mapped, coloured in zip(mesh.loops, mapping, colours, strict=True):
        x, y, z = rest[loop.vertex_index]
        assert np.allclose(mapped.uv, ((z + 3) / 6, x + y), atol=1e-5)
        assert np.allclose(coloured.color[:3], ((z + 3) / 6, x + 0.5, y + 0.5), atol=1e-5)
    for vertex, place in zip(mesh.vertices, rest, strict=True):
        weight = sum(entry.weight for entry in vertex.groups)
        assert weight == pytest.approx((place[2] + 3) / 6, abs=1e-5)
    lengths = [np.linalg.norm(np.diff(rest[list(edge.vertices)], axis=0)) for edge in mesh.edges if edge.use_seam]
    assert len(lengths) > seams
    assert sum(lengths) == pytest.approx(6.0 * seams, rel=1e-5)
    assert all(edge.use_edge_sharp == edge.use_seam for edge in mesh.edges)


def test_a_vertex_group_of_the_modifier_is_followed_and_a_tighter_tolerance_splits_more():
    counts = []
    for tolerance in (0.1, 0.01, 0.001):
        obj, _modifier = bar(Vertex_Group="Part")
        group = obj.vertex_groups.new(name="Part")
        group.add([4, 5, 6, 7], 1.0, "REPLACE")
        whole = scenes.volume(obj.data)
        bpy.context.view_layer.update()
        scenes.choose(obj)
        assert bpy.ops.isochor.apply(tolerance=tolerance) == {"FINISHED"}
        assert abs(scenes.volume(obj.data) / whole - 1) <= 1e-6
        assert borders(obj.data) == {2}
        counts.append(len(obj.data.vertices))
        scenes.empty_file()
    assert counts == sorted(set(counts))


def test_a_face_with_straight_edges_that_bulges_is_split_too():
    plate = scenes.mesh_object("Plate", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    lattice = scenes.lattice_object((3, 3, 2), size=2.0)
    scenes.volume_lattice(plate, lattice, Preserve=0.0)
    for point in lattice.data.points:
        if abs(point.co.x) < 0.1 and abs(point.co.y) < 0.1:
            point.co_deform.z += 1.0
    bpy.context.view_layer.update()
    applied(plate)
    points = scenes.positions(plate.data)
    assert len(points) > 50
    assert points[:, 2].max() == pytest.approx(0.5, abs=0.02)


def test_large_faces_islands_and_a_region_keep_their_volumes():
    ring = [(np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(7) / 7]
    points = [(x, y, z) for z in (-2.0, 2.0) for x, y in ring]
    sides = [(i, (i + 1) % 7, 7 + (i + 1) % 7, 7 + i) for i in range(7)]
    faces = [*sides, tuple(range(6, -1, -1)), tuple(range(7, 14))]
    obj = scenes.mesh_object("Prism", points, faces)
    lattice = scenes.lattice_object((3, 3, 4), size=4.4)
    modifier = scenes.volume_lattice(obj, lattice, Islands=True, Twist=1.2, Taper=0.4)
    whole = scenes.volume(obj.data)
    for point in lattice.data.points:
        if abs(point.co.x) < 0.1 and abs(point.co.y) < 0.1:
            point.co_deform.z *= 1.3
    bpy.context.view_layer.update()
    assert scenes.report(obj, modifier).problems == ()
    applied(obj)
    assert borders(obj.data) == {2}
    assert len(obj.data.vertices) > 100
    assert abs(scenes.volume(obj.data) / whole - 1) <= 1e-6


def test_a_tolerance_that_cannot_be_reached_is_said(monkeypatch):
    obj, _modifier = bar()
    monkeypatch.setattr(scenes.part("tool.splitting"), "LEVELS", 2)
    how = scenes.part("tool.applying").How(tolerance=1e-5)
    said = scenes.part("tool.applying").apply([(obj, obj.modifiers[0])], how, bpy.context)
    assert any("still farther" in text for text in said)
    assert borders(obj.data) == {2}


def test_refusals_change_nothing():
    obj, _modifier = bar()
    obj.shape_key_add(name="Basis")
    with pytest.raises(RuntimeError, match="has shape keys, which split faces do not have"):
        bpy.ops.isochor.apply(tolerance=0.1, as_shape_key=True)
    obj.shape_key_clear()
    lattice = scenes.lattice_object(3, name="Second", size=8.0)
    scenes.volume_lattice(obj, lattice)
    scenes.choose(lattice)
    scenes.get_input(obj.modifiers[0], "Lattice").select_set(True)
    with pytest.raises(RuntimeError, match="one at a time"):
        bpy.ops.isochor.apply(tolerance=0.1)
    assert len(obj.data.vertices) == 8
    assert len(obj.modifiers) == 2


def test_one_undo_step():
    obj, _modifier = bar()
    bpy.ops.ed.undo_push()
    scenes.choose(obj)
    bpy.ops.isochor.apply("EXEC_DEFAULT", True, tolerance=TOLERANCE)
    assert len(obj.data.vertices) > 40
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Bar"]
    assert len(obj.data.vertices) == 8
    assert len(obj.modifiers) == 1
