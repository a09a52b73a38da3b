# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume and extents of a triangulated Blender mesh, in float64 over the triangles that Blender renders."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SurfaceMeasure:
    """Signed volume, extents along x, y, z and lowest z of a surface, in scene units."""

    volume: float
    extents: tuple[float, float, float]
    lowest: float


def mesh_arrays(mesh: Any) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Positions (V, 3) float32 in the object's space and loop triangles (F, 3) int32 of a bpy Mesh."""
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions)
    triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return positions.reshape(-1, 3), triangles.reshape(-1, 3)


def drawn_arrays(evaluated: Any) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """``mesh_arrays`` of what Blender draws of an evaluated object, be it a mesh or, under a modifier, a text."""
    geometry = evaluated.evaluated_geometry()  # its mesh lives no longer than it does
    return mesh_arrays(evaluated.data if evaluated.type == "MESH" else geometry.mesh)


def enclosed_volume(positions: NDArray[Any], triangles: NDArray[np.int32]) -> float:
    """Signed volume of the closed surface, float64, summed about the mean of `positions` (V, 3)."""
    centred = positions.astype(np.float64)
    centred -= centred.mean(axis=0)
    first, second, third = (centred[triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", first, np.cross(second, third)).sum() / 6)


def measure(positions: NDArray[Any], triangles: NDArray[np.int32], matrix_world: Any) -> SurfaceMeasure:
    """SurfaceMeasure of `positions` (V, 3) placed by `matrix_world` (4, 4)."""
    matrix = np.array(matrix_world, dtype=np.float64)
    placed = positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    extents = np.ptp(placed, axis=0)
    return SurfaceMeasure(
        enclosed_volume(placed, triangles),
        (float(extents[0]), float(extents[1]), float(extents[2])),
        float(placed[:, 2].min()),
    )


def measure_evaluated(blender_object: Any, depsgraph: Any) -> SurfaceMeasure:
    """SurfaceMeasure of an object as `depsgraph` evaluated it, modifiers and all."""
    evaluated = blender_object.evaluated_get(depsgraph)
    return measure(*mesh_arrays(evaluated.data), evaluated.matrix_world)
