# SPDX-License-Identifier: GPL-3.0-or-later
"""Installing, updating, switching off and uninstalling the built zip, each in a Blender of its own."""

import os
import tomllib
import zipfile
from pathlib import Path

import other_blender
from installed_extension import ZIP

BUILT_ZIP = Path(os.environ[ZIP])

LOOK = """
from pathlib import Path

def ours():
    "What Blender knows of us: operators, panels and menus, preferences, handlers, timers, command lines, modules."
    names = [name for name in dir(bpy.types) if "isochor" in name.lower()]
    events = [event for event in dir(bpy.app.handlers) if isinstance(getattr(bpy.app.handlers, event), list)]
    hung = [f"{event}: {handler.__module__}.{handler.__name__}" for event in events
            for handler in getattr(bpy.app.handlers, event) if "isochor" in getattr(handler, "__module__", "")]
    menus = [menu for menu in ("OBJECT_MT_modifier_add_deform", "VIEW3D_MT_object", "VIEW3D_MT_edit_lattice",
                               "VIEW3D_PT_overlay", "TOPBAR_MT_file_export")
             if hasattr(bpy.types, menu) for draw in getattr(getattr(bpy.types, menu).draw, "_draw_funcs", [])
             if "isochor" in draw.__module__]
    operators = [name for name in dir(bpy.ops.isochor) if not name.startswith("_")]
    properties = [f"{kind}.{name}" for kind in ("Scene", "Object", "WindowManager", "Screen", "Lattice", "Mesh")
                  for name in getattr(bpy.types, kind).bl_rna.properties.keys() if "isochor" in name.lower()]
    return [*names, *hung, *menus, *operators, *properties]

def install(place):
    answer = bpy.ops.extensions.package_install_files(
        repo="user_default", filepath=place, enable_on_install=True, overwrite=True)
    assert answer == {"FINISHED"}, answer
    assert installed_extension.MODULE in bpy.context.preferences.addons

def uninstall():
    repo = [repo.module for repo in bpy.context.preferences.extensions.repos].index("user_default")
    assert bpy.ops.extensions.package_uninstall(repo_index=repo, pkg_id="isochor") == {"FINISHED"}

def folders():
    "Where something of ours lies in the user's folder."
    import os
    return [str(path) for path in Path(os.environ["BLENDER_USER_RESOURCES"]).rglob("*isochor*")]

def squashed_ball():
    import scenes
    scenes.empty_file()
    ball = scenes.sphere()
    bpy.ops.isochor.add()
    for point in bpy.data.objects["Ball Lattice"].data.points:
        point.co_deform.z *= 0.4
    bpy.context.view_layer.update()
    shown = scenes.evaluated_volume(ball)
    assert abs(shown / scenes.volume(ball.data) - 1) < 1e-6
    assert abs(scenes.evaluated_positions(ball)[:, 2]).max() < 0.6
    return ball
"""


def with_version(place: Path, version: str) -> Path:
    """The built zip as another version, all else the same."""
    other = place / f"isochor-{version}.zip"
    with zipfile.ZipFile(BUILT_ZIP) as source, zipfile.ZipFile(other, "w") as target:
        for entry in source.infolist():
            content = source.read(entry)
            if entry.filename == "blender_manifest.toml":
                present = tomllib.loads(content.decode())["version"]
                content = content.replace(f'version = "{present}"'.encode(), f'version = "{version}"'.encode(), 1)
            target.writestr(entry, content)
    return other


def test_a_fresh_blender_has_nothing_of_ours_and_after_installing_it_has(tmp_path):
    out = other_blender.run(
        LOOK + "assert not ours(), ours()\ninstall(arguments[0])\nsquashed_ball()\nprint('found', len(ours()))",
        tmp_path,
        BUILT_ZIP,
    )
    assert int(out.rsplit("found", 1)[1].split()[0]) >= 10


def test_uninstalling_leaves_nothing_behind(tmp_path):
    text = (
        LOOK
        + """
install(arguments[0])
squashed_ball()
bpy.ops.wm.save_as_mainfile(filepath=arguments[1])
assert folders()
uninstall()
assert installed_extension.MODULE not in bpy.context.preferences.addons
assert not ours(), ours()
assert not folders(), folders()
bpy.ops.wm.open_mainfile(filepath=arguments[1])
import scenes
bpy.context.scene.frame_set(3)
assert abs(scenes.evaluated_positions(bpy.data.objects["Ball"])[:, 2]).max() < 0.6, "the last shape stays"
"""
    )
    other_blender.run(text, tmp_path, BUILT_ZIP, tmp_path / "saved.blend")


def test_a_saved_file_shows_the_last_shape_where_the_extension_was_never_installed(tmp_path):
    save = LOOK + "install(arguments[0])\nball = squashed_ball()\n" + SAVE_SHAPE
    other_blender.run(save, tmp_path / "with", BUILT_ZIP, tmp_path / "saved.blend", tmp_path / "shape.npy")
    other_blender.run(SAME_SHAPE, tmp_path / "without", tmp_path / "saved.blend", tmp_path / "shape.npy")


SAVE_SHAPE = """
import numpy, scenes
numpy.save(arguments[2], scenes.evaluated_positions(ball))
bpy.ops.wm.save_as_mainfile(filepath=arguments[1])
"""
SAME_SHAPE = """
import numpy, scenes
bpy.ops.wm.open_mainfile(filepath=arguments[0])
shape = numpy.load(arguments[1])
for frame in (1, 7):
    bpy.context.scene.frame_set(frame)
    assert numpy.array_equal(scenes.evaluated_positions(bpy.data.objects["Ball"]), shape)
"""


def test_an_update_in_a_running_blender_keeps_working_and_what_is_in_the_file(tmp_path):
    text = (
        LOOK
        + """
import scenes
install(arguments[0])
before = sorted(ours())
ball = squashed_ball()
install(arguments[1])
import sys
assert sorted(ours()) == before, set(ours()) ^ set(before)
bpy.ops.wm.save_as_mainfile(filepath=arguments[2])
bpy.ops.wm.open_mainfile(filepath=arguments[2])
ball = bpy.data.objects["Ball"]
for point in bpy.data.objects["Ball Lattice"].data.points:
    point.co_deform.z *= 0.8
bpy.context.view_layer.update()
assert abs(scenes.evaluated_volume(ball) / scenes.volume(ball.data) - 1) < 1e-6
assert abs(scenes.evaluated_positions(ball)[:, 2]).max() < 0.5
manifest = Path(sys.modules[installed_extension.MODULE].__file__).with_name("blender_manifest.toml").read_text()
assert 'version = "9.9.9"' in manifest
"""
    )
    newer = with_version(tmp_path, "9.9.9")
    other_blender.run(text, tmp_path, BUILT_ZIP, newer, tmp_path / "saved.blend")


def test_switching_off_and_on_again_leaves_one_of_each(tmp_path):
    text = (
        LOOK
        + """
import addon_utils
install(arguments[0])
before = sorted(ours())
for _ in range(3):
    addon_utils.disable(installed_extension.MODULE)
    assert not ours(), ours()
    addon_utils.enable(installed_extension.MODULE)
    assert sorted(ours()) == before, set(ours()) ^ set(before)
squashed_ball()
"""
    )
    other_blender.run(text, tmp_path, BUILT_ZIP)


def test_the_zip_holds_one_wheel_and_it_is_the_one_that_was_built():
    with zipfile.ZipFile(BUILT_ZIP) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    wheels = [name for name in names if name.endswith(".whl")]
    assert [f"./{name}" for name in wheels] == manifest["wheels"]
    assert len(wheels) == 1
    assert "LICENSE" in names
    assert not [name for name in names if "__pycache__" in name or name.endswith((".pyc", ".so"))]
    assert os.path.getsize(BUILT_ZIP) < 20e6
