# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads which parts of a mesh are to keep a volume of their own."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..core import problem
from ..core.bodies import IN_REGION, Bodies
from ..core.settings import WHOLE, Parts


@dataclass
class Divided:
    """What was read last; the very same ``bodies`` as long as nothing has changed."""

    bodies: Bodies | None = None
    triangles: NDArray[np.int32] | None = field(default=None, repr=False)
    name: str = ""
    problems: list[str] = field(default_factory=list)

    def read(
        self,
        has_group: bool,
        parts: Parts,
        weights: NDArray[np.float32] | None,
        triangles: NDArray[np.int32] | None,
    ) -> tuple[Bodies | None, list[str]]:
        """The bodies, or None for one volume of all, and what is wrong with the region; ``has_group``: whether its
        group is there; ``weights`` (V,) are those of the vertices that entered in it, None where they are not known.
        """
        if parts is WHOLE or parts == WHOLE or triangles is None:
            self.bodies = None
            return None, []
        region = None if weights is None else weights >= IN_REGION
        asked = Bodies(parts.islands, parts.close_holes, region)
        known = triangles is self.triangles and parts.region == self.name and asked.same_as(self.bodies)
        if not known or self.problems:
            self.problems = _problems(has_group, parts.region, region, triangles)
            self.bodies = Bodies(parts.islands, parts.close_holes) if self.problems else asked
            self.triangles, self.name = triangles, parts.region
        return self.bodies if self.bodies is not None and self.bodies.kind else None, list(self.problems)


def _problems(has_group: bool, name: str, region: NDArray[np.bool_] | None, triangles: NDArray[np.int32]) -> list[str]:
    if not name:
        return []
    if region is None or not has_group:
        return [problem.no_region(name)]
    return [] if region[triangles].all(axis=1).any() else [problem.empty_region(name)]
