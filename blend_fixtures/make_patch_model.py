# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes patch_model.blend from nothing, headless: `python make_patch_model.py [--output FILE]`: the elephant as a
surface of NURBS patches, and tessellated as a mesh.

Needs the bpy module (4.5 to write the committed file, so that 4.5 and later open it).
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon" / "demo")]

import bpy  # noqa: E402
from blender_session import run_and_leave  # noqa: E402
from fixture_file import make  # noqa: E402
from models.elephant import elephant_mesh, make_elephant  # noqa: E402
from models.materials import elephant_material  # noqa: E402
from models.model_object import model_object  # noqa: E402
from patch_object import patch_surface  # noqa: E402

LEVEL, RESOLUTION = 4, 2
BESIDE = 3.2


def make_scene() -> tuple[bpy.types.Object, bpy.types.Object]:
    """The surface, and the mesh beside it, in the empty file that is open."""
    surface = patch_surface("Elephant Patches", make_elephant(), RESOLUTION)
    mesh = model_object("Elephant", elephant_mesh(LEVEL), elephant_material())
    mesh.location.y = BESIDE
    bpy.context.scene.collection.objects.link(mesh)
    bpy.context.view_layer.update()
    return surface, mesh


def main() -> None:
    make(make_scene, HERE / "patch_model.blend", __doc__.splitlines()[0])


if __name__ == "__main__":
    run_and_leave(main)
