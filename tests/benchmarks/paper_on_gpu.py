# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume paper's own formulation on an NVIDIA GPU: CSR matrices and cuSPARSE's products, through CuPy, in float32.

Hahmann et al. 2012, sections 5 and 6: the matrix of N control points × F faces is built beforehand; each of the three
axes' products with the faces' area vectors, the volume, the update and the FFD count.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cupy
import numpy as np
from cupyx.scipy import sparse
from native_bench import Paper
from numpy.typing import NDArray
from oracle import Spec


@dataclass
class PaperOnGpu:
    """Both matrices and the triangles in the memory of the GPU."""

    weights: Any  # (V, N): B_ijk(u_v)
    faces: Any  # (N, F): (B_ijk(u_l) + B_ijk(u_m) + B_ijk(u_n)) / 6
    triangles: Any

    @classmethod
    def of(cls, spec: Spec, vertices: NDArray, triangles: NDArray) -> PaperOnGpu:
        paper = Paper.of(spec, vertices.astype(np.float64), triangles)
        cupy.get_default_memory_pool().free_all_blocks()
        matrices = [sparse.csr_matrix(matrix.astype(np.float32)) for matrix in (paper.weights, paper.faces)]
        return cls(*matrices, cupy.asarray(triangles))

    @property
    def bytes(self) -> int:
        """All that CuPy took for it so far: matrices, triangles, vertices and what the products pass through."""
        return int(cupy.get_default_memory_pool().total_bytes())

    def determinants(self, vertices: Any, axis: int) -> Any:
        """(F,): the determinant of equation (10), (11) or (12)."""
        (al, am, an), (bl, bm, bn) = (vertices[:, (axis + turn) % 3][self.triangles.T] for turn in (1, 2))
        return (am - al) * (bn - bl) - (an - al) * (bm - bl)

    def sweep(self, control: Any, reference: float) -> Any:
        """Control points (N, 3) after x, y and z have each taken a third: equations (13)-(17)."""
        control = control.copy()
        vertices = cupy.asfortranarray(self.weights @ control)
        along = vertices[:, 2][self.triangles.T].sum(axis=0)
        part = (reference - (along * self.determinants(vertices, 2)).sum() / 6) / 3
        for axis in range(3):
            coefficients = self.faces @ self.determinants(vertices, axis)
            control[:, axis] += part / (coefficients @ coefficients) * coefficients
            vertices[:, axis] = self.weights @ control[:, axis]
        return control

    def median_seconds(self, control: NDArray, reference: float, repeats: int) -> float:
        """Of the GPU's own clock, after a warm-up."""
        points = cupy.asarray(control.reshape(-1, 3), dtype=cupy.float32)
        took = []
        for turn in range(repeats + 1):
            start, end = cupy.cuda.Event(), cupy.cuda.Event()
            start.record()
            self.sweep(points, reference)
            end.record()
            end.synchronize()
            if turn:
                took.append(cupy.cuda.get_elapsed_time(start, end) * 1e-3)
        return float(np.median(took))

    def delta(self, control: NDArray, reference: float) -> NDArray:
        """(N, 3): how far the control points move."""
        points = cupy.asarray(control.reshape(-1, 3), dtype=cupy.float32)
        return cupy.asnumpy(self.sweep(points, reference) - points)
