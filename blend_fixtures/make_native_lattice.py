# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes native_lattice.blend from nothing, headless: `python make_native_lattice.py [--output FILE]`: a shot with
Blender's own Lattice modifier, to be converted.

Needs the bpy module (4.5 to write the committed file, so that 4.5 and later open it).
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon" / "demo")]

import bpy  # noqa: E402
from blender_session import run_and_leave  # noqa: E402
from fixture_file import make  # noqa: E402
from models.elephant import elephant_mesh  # noqa: E402
from models.materials import elephant_material  # noqa: E402
from models.model_object import model_object  # noqa: E402
from pages.converted import squashing_lattice  # noqa: E402

LEVEL = 4
FRAMES = (1, 12, 24)


def make_scene() -> bpy.types.Object:
    """The elephant under a native lattice whose shape and place are keyed, in the empty file that is open."""
    scene = bpy.context.scene
    elephant = model_object("Elephant", elephant_mesh(LEVEL), elephant_material())
    lattice = squashing_lattice(elephant)
    for obj in (elephant, lattice):
        scene.collection.objects.link(obj)
    modifier = elephant.modifiers.new("Lattice", "LATTICE")
    modifier.object = lattice
    for frame, strength in zip(FRAMES, (0.0, 1.0, 0.4)):
        modifier.strength = strength
        modifier.keyframe_insert("strength", frame=frame)
        lattice.rotation_euler.z = 0.3 * strength
        lattice.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    return elephant


def main() -> None:
    make(make_scene, HERE / "native_lattice.blend", __doc__.splitlines()[0])


if __name__ == "__main__":
    run_and_leave(main)
