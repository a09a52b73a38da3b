# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the shot that the jobs bake and render: two balls in squashed lattices, small and quick to render.

Use: blender --background --python make_shot.py -- FILE
"""

import sys

import bpy

FRAMES = (1, 5)


def main(place: str) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    for name, x in (("Ball", -1.2), ("Big Nose", 1.2)):
        add_ball(name, x)
    add_camera_and_light()
    set_up_render()
    bpy.ops.wm.save_as_mainfile(filepath=place)


def add_ball(name: str, x: float) -> None:
    """A ball in a volume lattice that is squashed from frame to frame."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, location=(x, 0.0, 0.0))
    bpy.context.object.name = name
    if bpy.ops.isochor.add(resolution=(3, 3, 3)) != {"FINISHED"}:
        raise RuntimeError("isochor.add did not work")
    lattice = next(obj for obj in bpy.data.objects if obj.type == "LATTICE" and not obj.data.shape_keys)
    lattice.shape_key_add(name="Basis")
    key = lattice.shape_key_add(name="Squash")
    for point in key.data:
        a, b, c = point.co
        point.co = (a + 0.2 * x * c, b, 0.5 * c)
    for frame, value in zip(FRAMES, (0.0, 1.0), strict=True):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def add_camera_and_light() -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -8.0, 0.0), (1.5708, 0.0, 0.0)
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    light.rotation_euler = (0.6, 0.3, 0.0)
    for obj in (camera, light):
        bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = camera


def set_up_render() -> None:
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAMES
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = 1, False, 1
    scene.render.resolution_x, scene.render.resolution_y = 48, 24
    scene.render.image_settings.file_format = "PNG"


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1])
