# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file shows and renders in a Blender that does not have the extension."""

from pathlib import Path

import bpy
import numpy as np
import processes
from numpy.typing import NDArray

PLAY = """
import bpy, numpy as np
place, name, out, *frames = sys.argv[1:]
assert not [key for key in bpy.context.preferences.addons.keys() if "isochor" in key]
bpy.ops.wm.open_mainfile(filepath=place)
assert not hasattr(bpy.types, "ISOCHOR_OT_add")
found = []
for frame in map(float, frames):
    bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
    mesh = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", points)
    found.append(points.reshape(-1, 3))
np.save(out, np.array(found))
"""

RENDER = """
import bpy
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
assert not hasattr(bpy.types, "ISOCHOR_OT_add")
bpy.context.scene.render.filepath = sys.argv[2]
bpy.ops.render.render(animation=True)
"""


def played(folder: Path, name: str, frames: list[float]) -> NDArray[np.float64]:
    """(frames, V, 3) vertices of the object of that name, in object space, from the file as it stands now."""
    place, out = str(folder / "played.blend"), str(folder / "played.npy")
    bpy.ops.wm.save_as_mainfile(filepath=place, copy=True)
    done = processes.run_script(PLAY, place, name, out, *map(str, frames))
    assert done.returncode == 0, done.stdout + done.stderr
    found: NDArray[np.float64] = np.load(out).astype(np.float64)
    return found


def rendered(folder: Path) -> Path:
    """The folder of the pictures that the file as it stands now renders."""
    place, out = str(folder / "rendered.blend"), folder / "pictures"
    bpy.ops.wm.save_as_mainfile(filepath=place, copy=True)
    done = processes.run_script(RENDER, place, f"{out}/")
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def volume(points: NDArray[np.float64], obj: bpy.types.Object) -> float:
    """Signed volume of (V, 3) vertices over the triangles of the object's mesh, in float64."""
    mesh = obj.data
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    a, b, c = points[triangles.reshape(-1, 3)].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
