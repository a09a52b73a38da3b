# SPDX-License-Identifier: GPL-3.0-or-later
"""Wherever the objects are: hidden, excluded, in other scenes and view layers, shared, copied, linked, being edited."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import scenes
from drawn import Layout, drawn

HIDINGS = ("eye", "object", "collection", "layer", "exclude", "unlinked")


def squashed_ball(name: str = "Ball"):
    ball, lattice = scenes.sphere(name=name), scenes.lattice_object(4, name=f"{name} Cage")
    modifier = scenes.volume_lattice(ball, lattice)
    squash(lattice, 0.8)
    return ball, lattice, modifier


def squash(lattice: bpy.types.Object, factor: float) -> None:
    for point in lattice.data.points:
        point.co_deform.z *= factor
    bpy.context.view_layer.update()


def keyed_squash(lattice: bpy.types.Object) -> None:
    """Half as high at frame 11 as at frame 1."""
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash")
    for point in key.data:
        point.co.z *= 0.5
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def height(obj: bpy.types.Object, layer: bpy.types.ViewLayer | None = None) -> float:
    return float(np.ptp(scenes.evaluated_positions(obj, None if layer is None else layer.depsgraph)[:, 2]))


def keeps_volume(obj: bpy.types.Object, layer: bpy.types.ViewLayer | None = None) -> bool:
    found = scenes.evaluated_volume(obj, None if layer is None else layer.depsgraph)
    return abs(found / scenes.volume(obj.data) - 1) <= 1e-6


def into_collection(obj: bpy.types.Object, name: str) -> bpy.types.Collection:
    """Moves the object into a new collection of the scene."""
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    for other in obj.users_collection:
        other.objects.unlink(obj)
    collection.objects.link(obj)
    return collection


def hide(obj: bpy.types.Object, how: str) -> None:
    collection = into_collection(obj, "Hidden")
    bpy.context.view_layer.update()
    layer = bpy.context.view_layer.layer_collection.children["Hidden"]
    if how == "eye":
        obj.hide_set(True)
    elif how == "object":
        obj.hide_viewport = True
    elif how == "collection":
        collection.hide_viewport = True
    elif how == "layer":
        layer.hide_viewport = True
    elif how == "exclude":
        layer.exclude = True
    else:
        collection.objects.unlink(obj)
    bpy.context.view_layer.update()


def show(obj: bpy.types.Object) -> None:
    layer = bpy.context.view_layer.layer_collection.children["Hidden"]
    layer.exclude = layer.hide_viewport = layer.collection.hide_viewport = obj.hide_viewport = False
    if obj.name not in layer.collection.objects:
        layer.collection.objects.link(obj)
    bpy.context.view_layer.update()
    obj.hide_set(False)
    bpy.context.view_layer.update()


def lattices() -> list[str]:
    return [obj.name for obj in bpy.data.objects if obj.type == "LATTICE"]


def undone(name: str = "Ball") -> bpy.types.Object:
    bpy.ops.ed.undo()
    bpy.context.view_layer.update()
    return bpy.data.objects[name]


@pytest.mark.parametrize("how", HIDINGS)
def test_a_hidden_lattice_shapes_the_mesh_as_if_it_showed(how):
    ball, lattice, modifier = squashed_ball()
    keyed_squash(lattice)
    bpy.context.scene.frame_set(6)
    wanted = [height(ball)]
    bpy.context.scene.frame_set(11)
    wanted.append(height(ball))
    hide(lattice, how)
    assert not lattice.visible_get()
    for frame, value in zip((6, 11), wanted, strict=True):
        bpy.context.scene.frame_set(frame)
        assert height(ball) == value
        assert keeps_volume(ball)
    lattice.data.shape_keys.key_blocks["Squash"].data[21].co.y += 0.5
    lattice.data.update_tag()
    bpy.context.view_layer.update()
    lattice.location.x += 0.1
    bpy.context.view_layer.update()
    assert keeps_volume(ball)
    assert not scenes.report(ball, modifier).problems
    assert wanted[0] > 1.1 * wanted[1]


@pytest.mark.parametrize("how", HIDINGS)
def test_a_hidden_mesh_is_right_when_it_shows_again(how):
    ball, lattice, _ = squashed_ball()
    before = height(ball)
    hide(ball, how)
    bpy.context.scene.frame_set(4)
    squash(lattice, 0.7)
    show(ball)
    assert height(ball) < 0.9 * before
    assert keeps_volume(ball)


@pytest.mark.parametrize("how", ["eye", "object", "collection", "layer", "exclude"])
def test_operators_leave_a_hidden_lattice_be_or_take_it_away_whole(how):
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    lattice = scenes.get_input(ball.modifiers[0], "Lattice")
    hide(lattice, how)
    scenes.choose(ball)
    assert bpy.ops.isochor.mirror_lattice(axis="X") == {"FINISHED"}
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not bpy.data.lattices
    assert [obj.name for obj in bpy.data.objects] == ["Ball"]


@pytest.mark.parametrize("how", ["layer", "collection", "linked"])
def test_add_puts_the_lattice_where_it_shows(how, tmp_path):
    place = str(tmp_path / "library.blend")
    foreign = bpy.data.collections.new("Foreign")
    bpy.data.libraries.write(place, {foreign})
    scenes.empty_file()
    ball = scenes.sphere()
    into_collection(ball, "Around")
    if how == "linked":
        with bpy.data.libraries.load(place, link=True) as (_found, wanted):
            wanted.collections = ["Foreign"]
        collection = wanted.collections[0]
    else:
        collection = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(collection)
    layer = bpy.context.view_layer.layer_collection.children[collection.name]
    if how != "linked":
        layer.hide_viewport, collection.hide_viewport = how == "layer", how == "collection"
    bpy.context.view_layer.active_layer_collection = layer
    assert bpy.context.view_layer.active_layer_collection.name == collection.name
    scenes.choose(ball)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    lattice = scenes.get_input(ball.modifiers[0], "Lattice")
    assert lattice.visible_get()
    assert [found.name for found in lattice.users_collection] == ["Around"]


def test_add_in_a_local_view_shows_the_lattice_in_it():
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    scenes.choose(bpy.data.objects["Cube"])
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.localview(frame_selected=False)
        if not bpy.data.objects["Cube"].local_view_get(area.spaces.active):
            pytest.skip("Blender 4.5 has no local view without a window")
        bpy.ops.isochor.add()
        assert bpy.data.objects["Cube Lattice"].local_view_get(area.spaces.active)
        assert not bpy.data.objects["Light"].local_view_get(area.spaces.active)
        bpy.ops.view3d.localview(frame_selected=False)


def test_remove_takes_it_from_every_selected_mesh_in_one_undo_step():
    first, second = scenes.sphere(name="First"), scenes.sphere(name="Second")
    third, _, _ = squashed_ball("Third")
    scenes.choose(first)
    second.select_set(True)
    bpy.ops.isochor.add()
    assert lattices() == ["First Lattice", "Third Cage"]
    bpy.ops.ed.undo_push(message="added")
    bpy.ops.isochor.remove("EXEC_DEFAULT", True)
    assert not first.modifiers
    assert not second.modifiers
    assert len(third.modifiers) == 1
    assert lattices() == ["Third Cage"]
    bpy.ops.ed.undo()
    assert [len(bpy.data.objects[name].modifiers) for name in ("First", "Second", "Third")] == [1, 1, 1]
    bpy.ops.ed.redo()
    assert [len(bpy.data.objects[name].modifiers) for name in ("First", "Second", "Third")] == [0, 0, 1]


def test_remove_from_the_lattice_takes_it_from_all_its_meshes():
    first, second = scenes.sphere(name="First"), scenes.sphere(name="Second")
    first.select_set(True)
    bpy.ops.isochor.add()
    scenes.choose(scenes.get_input(first.modifiers[0], "Lattice"))
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert not first.modifiers
    assert not second.modifiers
    assert not bpy.data.lattices
    assert not bpy.data.node_groups


@pytest.mark.parametrize("edited", ["mesh", "lattice"])
def test_operators_in_edit_mode(edited):
    ball, lattice, _ = squashed_ball()
    other = scenes.sphere(name="Other")
    scenes.choose(ball if edited == "mesh" else lattice)
    bpy.ops.object.mode_set(mode="EDIT")
    other.select_set(True)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    assert len(other.modifiers) == 1
    other.select_set(False)
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    if edited == "lattice":
        assert not ball.modifiers
        assert len(other.modifiers) == 1
        assert keeps_volume(other)
    else:
        assert len(ball.modifiers) == 1
        assert keeps_volume(ball)


def shown_names() -> list[str]:
    sidebar = scenes.part("ui.sidebar")
    return [sidebar.title(bpy.context, obj, modifier) for obj, modifier in sidebar.shown(bpy.context)]


def test_the_sidebar_serves_from_the_mesh_and_from_the_lattice_also_while_it_is_edited():
    sidebar = scenes.part("ui.sidebar")
    first, lattice, _ = squashed_ball("First")
    second = scenes.sphere(name="Second")
    scenes.volume_lattice(second, lattice)
    lonely = scenes.lattice_object(3, name="Lonely")
    scenes.choose(first)
    assert shown_names() == ["Volume Lattice"]
    scenes.choose(lattice)
    assert shown_names() == ["First: Volume Lattice", "Second: Volume Lattice"]
    bpy.ops.object.mode_set(mode="EDIT")
    assert shown_names() == ["First: Volume Lattice", "Second: Volume Lattice"]
    bpy.ops.object.mode_set(mode="OBJECT")
    scenes.choose(lonely)
    assert shown_names() == []
    assert sidebar.nothing_to_show(bpy.context) == "No mesh uses this lattice"
    bpy.context.view_layer.objects.active = None
    assert shown_names() == []
    assert sidebar.nothing_to_show(bpy.context) == "The active object has none"


def test_what_the_tab_draws():
    panel = scenes.part("ui.sidebar").VIEW3D_PT_isochor
    ball, lattice, modifier = squashed_ball()
    lines = drawn(panel, object=ball)
    assert lines[0] == "Volume Lattice"
    for name in ("Target volume", "Lattice alone", "Corrected", "Error", "Vertices outside", "Time"):
        assert name in lines
    assert {"isochor.add", "isochor.remove", "isochor.fit_lattice", "isochor.mirror_lattice"} <= set(lines)
    assert drawn(panel, object=lattice)[0] == "Ball: Volume Lattice"
    scenes.set_input(modifier, "Vertex Group", "Nowhere")
    bpy.context.view_layer.update()
    assert "There is no vertex group “Nowhere”" in " ".join(drawn(panel, object=ball))
    bpy.context.view_layer.objects.active = None
    assert drawn(panel, object=None)[0] == "The active object has none"
    menu = drawn(scenes.part("ui.menus").VIEW3D_MT_isochor)
    assert {"isochor.add", "isochor.fit_lattice", "isochor.mirror_lattice", "isochor.remove"} <= set(menu)


def test_an_object_in_two_scenes_shows_each_scene_s_own_frame():
    ball, lattice, _ = squashed_ball()
    keyed_squash(lattice)
    one, two = bpy.context.scene, bpy.data.scenes.new("Two")
    two.collection.objects.link(ball)
    two.collection.objects.link(lattice)
    for _ in range(2):
        one.frame_set(1)
        two.frame_set(11)
        one.view_layers[0].update()
        two.view_layers[0].update()
        assert height(ball, one.view_layers[0]) > 1.2 * height(ball, two.view_layers[0])
        assert keeps_volume(ball, one.view_layers[0])
        assert keeps_volume(ball, two.view_layers[0])


def test_showing_a_scene_for_the_first_time_shows_what_the_lattice_became():
    ball, lattice, _ = squashed_ball()
    before = height(ball)
    two = bpy.data.scenes.new("Two")
    two.collection.objects.link(ball)
    bpy.context.scene.collection.objects.unlink(ball)
    squash(lattice, 0.7)
    bpy.context.window_manager.windows[0].scene = two
    assert height(ball, two.view_layers[0]) < 0.9 * before
    assert keeps_volume(ball, two.view_layers[0])


def test_rendering_another_scene_than_the_window_s():
    ball, lattice, modifier = squashed_ball()
    keyed_squash(lattice)
    two = bpy.data.scenes.new("Two")
    two.collection.objects.link(ball)
    bpy.context.scene.collection.objects.unlink(ball)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    two.collection.objects.link(camera)
    two.camera = camera
    two.render.engine, two.render.resolution_x, two.render.resolution_y = "CYCLES", 8, 8
    two.cycles.samples = 1
    bpy.ops.render.render(scene="Two")
    rendered = float(np.ptp(scenes.positions(scenes.get_input(modifier, "Render Result").data)[:, 2]))
    two.frame_set(two.frame_current)
    assert rendered == height(ball, two.view_layers[0]) < 1.8
    volumes = scenes.report(ball, modifier, "RENDER").volumes
    assert volumes.error <= 1e-6
    assert volumes.before < 0.9 * volumes.target


def test_a_view_layer_that_excludes_the_mesh_does_not_hinder_the_other():
    ball, lattice, _ = squashed_ball()
    keyed_squash(lattice)
    first = bpy.context.view_layer
    second = bpy.context.scene.view_layers.new("Second")
    into_collection(ball, "Hidden")
    first.layer_collection.children["Hidden"].exclude = True
    for frame in (1, 11):
        bpy.context.scene.frame_set(frame)
        second.update()
        bpy.context.scene.frame_set(frame)
    assert ball.name not in first.objects
    assert scenes.evaluated_positions(ball, second.depsgraph).shape == scenes.positions(ball.data).shape
    first.layer_collection.children["Hidden"].exclude = False
    bpy.context.scene.frame_set(11)
    assert height(ball, first) < 1.4
    assert keeps_volume(ball, first)


def test_an_instanced_collection_follows_though_the_original_is_excluded():
    ball, lattice, _ = squashed_ball()
    collection = into_collection(ball, "Hidden")
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    bpy.context.scene.collection.objects.link(instance)
    bpy.context.view_layer.layer_collection.children["Hidden"].exclude = True
    bpy.context.view_layer.update()
    heights = []
    for factor in (1.0, 0.7):
        squash(lattice, factor)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        (mesh,) = [found.object.data for found in depsgraph.object_instances if found.object.type == "MESH"]
        heights.append(float(np.ptp(scenes.positions(mesh)[:, 2])))
        assert abs(scenes.volume(mesh) / scenes.volume(ball.data) - 1) <= 1e-6
    assert heights[1] < 0.9 * heights[0]


def test_a_linked_duplicate_shares_the_mesh_and_has_a_deformation_of_its_own():
    ball, lattice, _ = squashed_ball()
    scenes.choose(ball)
    bpy.ops.object.duplicate(linked=True)
    twin = bpy.context.object
    assert twin.data == ball.data
    twin.location.x = 1.0
    twin.rotation_euler.z = 0.5
    cage = scenes.lattice_object(4, name="Twin Cage", size=5.0)
    scenes.set_input(twin.modifiers[0], "Lattice", cage)
    squash(cage, 1.4)
    assert height(twin) > 1.3 * height(ball)
    assert keeps_volume(twin)
    assert keeps_volume(ball)
    scenes.choose(twin)
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    squash(lattice, 0.9)
    assert keeps_volume(ball)
    assert height(ball) < 1.7
    assert np.array_equal(scenes.evaluated_positions(twin), scenes.positions(ball.data))


def test_renaming_moving_and_switching_the_modifier_with_undo_and_redo():
    ball, lattice, modifier = squashed_ball()
    ball.modifiers.new("Subdivision", "SUBSURF")
    modifier.name, ball.name, lattice.name = "Shape", "Pumpkin", "Box"
    bpy.context.view_layer.update()
    low = height(ball)
    bpy.ops.ed.undo_push(message="below")
    ball.modifiers.move(0, 1)
    bpy.context.view_layer.update()
    assert keeps_volume(ball)
    assert not scenes.report(ball, ball.modifiers["Shape"]).problems
    bpy.ops.ed.undo_push(message="moved")
    ball.modifiers["Shape"].show_viewport = False
    bpy.context.view_layer.update()
    assert height(ball) > 1.9
    squash(lattice, 0.7)
    assert height(ball) > 1.9
    bpy.ops.ed.undo_push(message="off")
    ball.modifiers["Shape"].show_viewport = True
    bpy.context.view_layer.update()
    assert height(ball) < 0.85 * low
    bpy.ops.ed.undo_push(message="on")
    ball = undone("Pumpkin")
    assert height(ball) > 1.9
    ball = undone("Pumpkin")
    assert abs(height(ball) - low) < 0.05
    ball = undone("Pumpkin")
    assert [found.name for found in ball.modifiers] == ["Shape", "Subdivision"]
    assert abs(height(ball) - low) < 1e-6
    bpy.ops.ed.redo()
    assert [found.name for found in bpy.data.objects["Pumpkin"].modifiers] == ["Subdivision", "Shape"]


def test_deleting_the_lattice_in_the_viewport_is_told_and_can_be_undone():
    ball, lattice, modifier = squashed_ball()
    low = height(ball)
    notes = scenes.part("ui.sidebar").notes
    assert notes(modifier.id_data, modifier) == []
    bpy.ops.ed.undo_push(message="before")
    scenes.choose(lattice)
    bpy.ops.object.delete()
    bpy.context.view_layer.update()
    # As all that a Geometry Nodes modifier refers to, it stays in the file and goes on to shape the mesh.
    assert height(ball) == low
    (text,) = notes(modifier.id_data, modifier)
    assert "“Ball Cage” is in no scene" in text
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    assert height(ball) > 1.9
    assert notes(modifier.id_data, modifier) == []
    bpy.ops.ed.undo_push(message="deleted")
    ball = undone()
    assert abs(height(ball) - low) < 1e-6
    squash(bpy.data.objects["Ball Cage"], 0.7)
    assert height(ball) < 0.85 * low
    assert keeps_volume(ball)


def test_deleting_a_selected_mesh_with_its_modifier_and_undoing_that():
    ball, _lattice, _ = squashed_ball()
    low = height(ball)
    bpy.ops.ed.undo_push(message="before")
    scenes.choose(ball)
    bpy.ops.object.delete()
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="deleted")
    ball = undone()
    assert abs(height(ball) - low) < 1e-6
    assert keeps_volume(ball)


def saved_library(tmp_path) -> str:
    """A file with a ball and its lattice, keyed, in the collection Character."""
    ball, lattice, _ = squashed_ball()
    keyed_squash(lattice)
    bpy.context.scene.frame_set(6)
    character = bpy.data.collections.new("Character")
    bpy.context.scene.collection.children.link(character)
    for obj in (ball, lattice):
        character.objects.link(obj)
        bpy.context.scene.collection.objects.unlink(obj)
    place = str(tmp_path / "character.blend")
    bpy.ops.wm.save_as_mainfile(filepath=place)
    scenes.empty_file()
    return place


def linked_character(place: str) -> bpy.types.Collection:
    with bpy.data.libraries.load(place, link=True) as (_found, wanted):
        wanted.collections = ["Character"]
    return wanted.collections[0]


def local(name: str) -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.name == name and obj.library is None)


def cancelled(operator, **properties) -> str:
    with pytest.raises(RuntimeError) as caught:
        operator(**properties)
    return str(caught.value)


def test_a_linked_character_keeps_its_shape_and_operators_refuse_it_in_plain_words(tmp_path):
    place = saved_library(tmp_path)
    character = linked_character(place)
    bpy.context.scene.collection.children.link(character)
    ball = character.objects["Ball"]
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) <= 1e-6
    (text,) = scenes.report(ball, ball.modifiers[0]).problems
    assert "make a library override of it" in text
    scenes.choose(ball)
    count = len(bpy.data.objects)
    for operator in (bpy.ops.isochor.add, bpy.ops.isochor.remove):
        assert "make it local or override it" in cancelled(operator)
    assert len(bpy.data.objects) == count
    assert len(ball.modifiers) == 1


def test_an_overridden_character_follows_its_lattice_and_keeps_the_library_s_modifier(tmp_path):
    place = saved_library(tmp_path)
    character = linked_character(place)
    character.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    ball, lattice = local("Ball"), local("Ball Cage")
    heights = []
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        assert keeps_volume(ball)
        heights.append(height(ball))
    assert heights[0] > 1.1 * heights[1] > 1.2 * heights[2]
    assert not scenes.report(ball, ball.modifiers[0]).problems
    lattice.scale.z *= 0.9
    bpy.context.view_layer.update()
    shape = height(ball)
    assert keeps_volume(ball)
    scenes.choose(ball)
    assert "“Volume Lattice” of “Ball” comes from another file" in cancelled(bpy.ops.isochor.remove)
    assert bpy.ops.isochor.add() == {"FINISHED"}
    assert bpy.ops.isochor.remove() == {"FINISHED"}
    assert [found.name for found in ball.modifiers] == ["Volume Lattice"]
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    ball = local("Ball")
    assert keeps_volume(ball)
    bpy.context.scene.frame_set(11)
    assert abs(height(ball) - shape) < 1e-6
    bpy.context.scene.frame_set(1)
    assert keeps_volume(ball)
    assert height(ball) > shape


def test_opening_a_shot_shows_what_its_library_became_meanwhile(tmp_path):
    place = saved_library(tmp_path)
    linked_character(place).override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    bpy.context.scene.frame_set(1)
    before = height(local("Ball"))
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=place)
    for block in bpy.data.objects["Ball Cage"].data.shape_keys.key_blocks:
        for point in block.data:
            point.co.z *= 0.7
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=shot)
    ball = local("Ball")
    bpy.context.view_layer.update()
    assert height(ball) < 0.9 * before
    assert keeps_volume(ball)
    assert not scenes.report(ball, ball.modifiers[0]).problems


def test_making_a_linked_character_local_lets_it_follow(tmp_path):
    place = saved_library(tmp_path)
    character = linked_character(place)
    bpy.context.scene.collection.children.link(character)
    for obj in character.objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = character.objects["Ball"]
    bpy.ops.object.make_local(type="ALL")
    ball, lattice = local("Ball"), local("Ball Cage")
    bpy.context.scene.frame_set(1)
    assert keeps_volume(ball)
    before = height(ball)
    lattice.scale.z *= 0.8
    bpy.context.scene.frame_set(11)
    assert height(ball) < 0.9 * before
    assert keeps_volume(ball)


def test_the_menu_is_reached_from_object_mode_and_from_the_lattice_s_edit_mode():
    for name in ("VIEW3D_MT_object", "VIEW3D_MT_edit_lattice"):
        layout = Layout()
        for draw in getattr(bpy.types, name)._dyn_ui_initialize():
            if draw.__module__.startswith(scenes.part("tool.device").PACKAGE):
                draw(SimpleNamespace(layout=layout), bpy.context)
        assert layout.lines == ["VIEW3D_MT_isochor"], name


CHANGES_NO_DATA = {"isochor.clear_memory"}
"""Operators with nothing to undo."""


def our_classes(kind: type) -> list[type]:
    """Registered classes of the add-on of one of Blender's kinds."""
    package = scenes.part("tool.device").PACKAGE
    return [found for found in kind.__subclasses__() if found.__module__.startswith(package) and found.is_registered]


def tooltip(one: type) -> str:
    if issubclass(one, bpy.types.Operator):
        package, name = one.bl_idname.split(".")
        return getattr(getattr(bpy.ops, package), name).get_rna_type().description.strip()
    return (getattr(one, "bl_description", "") or one.__doc__ or "").strip()


def test_everything_says_what_it_does():
    kinds = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.AddonPreferences, bpy.types.PropertyGroup)
    found = [one for kind in kinds for one in our_classes(kind)]
    assert len(found) >= 7
    for one in found:
        base = one.__base__.bl_rna
        assert tooltip(one) not in ("", base.description), one
        for own in one.bl_rna.properties:
            if own.identifier in base.properties or own.identifier == "rna_type":
                continue
            assert own.name.strip(), (one, own.identifier)
            assert own.description.strip(), (one, own.identifier)
            if own.type == "ENUM" and not own.is_enum_flag:
                assert all(item.name and item.description for item in own.enum_items_static), (one, own.identifier)


def test_operators_can_be_undone_where_they_change_anything():
    operators = our_classes(bpy.types.Operator)
    assert len(operators) >= 4
    for one in operators:
        assert ("UNDO" in one.bl_options) == (one.bl_idname not in CHANGES_NO_DATA), one.bl_idname


def test_every_input_of_the_modifier_says_what_it_does():
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    for item in ball.modifiers[0].node_group.interface.items_tree:
        if item.item_type == "SOCKET" and item.socket_type != "NodeSocketGeometry":
            assert item.description.strip(), item.name
