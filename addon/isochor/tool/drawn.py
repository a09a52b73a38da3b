# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether Blender draws another volume than the one that is kept, since it cuts quads anew after each deformation."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..core import problem, quads
from ..core.report import Report
from .evaluated import Faces

NOTICEABLE = 1e-6
"""Fraction of the volume below which nothing is said: as exact as anything in float32 is promised to be."""


@dataclass
class Cuts:
    """The quads of a mesh and how the triangles whose volume is kept cut them; a text for the report last asked for."""

    triangles: NDArray[np.int32] | None = field(default=None, repr=False)
    quads: NDArray[np.int32] | None = field(default=None, repr=False)
    first_to_third: NDArray[np.bool_] | None = field(default=None, repr=False)
    report: Report | None = None
    text: str = ""

    def note(self, report: Report, faces: Faces) -> str:
        """In plain words how far off the drawn volume is, or nothing; worked out once for each report."""
        if report is not self.report:
            self.report, self.text = report, self._fresh(report, faces)
        return self.text

    def _fresh(self, report: Report, faces: Faces) -> str:
        result, vertices, triangles = report.result, report.vertices, faces.triangles
        if result is None or not report.keeps_volume or vertices is None or triangles is None:
            return ""
        if len(vertices) > quads.MOST_VERTICES:
            return ""
        if triangles is not self.triangles:
            self.triangles, self.quads = triangles, faces.quads()
            self.first_to_third = quads.cut_first_to_third(self.quads, triangles)
        if self.quads is None or self.first_to_third is None or not len(self.quads):
            return ""
        if self.quads.max() >= len(vertices):
            return ""
        count, more = quads.drawn_volume(vertices, self.quads, self.first_to_third)
        share = more / result.target
        return problem.drawn_otherwise(count, share) if abs(share) > NOTICEABLE else ""
