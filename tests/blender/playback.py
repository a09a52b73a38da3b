# SPDX-License-Identifier: GPL-3.0-or-later
"""What a saved file shows in a Blender that does not have the extension."""

import tempfile
from pathlib import Path

import numpy as np
import processes
from numpy.typing import NDArray

SCRIPT = """
import bpy, numpy as np
blend, name, out, *texts = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=blend)
assert not hasattr(bpy.types, "ISOCHOR_OT_add"), "the add-on is there"
found = []
for text in texts:
    frame = float(text)
    bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
    mesh = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    positions = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions)
    found.append(positions.reshape(-1, 3))
np.save(out, np.array(found))
"""


def without_the_add_on(blend: Path, name: str, frames: list[float]) -> NDArray[np.float32]:
    """(F, V, 3) vertices of the object in each of these frames."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "shapes.npy"
        done = processes.run_script(SCRIPT, str(blend), name, str(out), *map(str, frames))
        assert out.is_file(), done.stdout + done.stderr
        return np.load(out)
