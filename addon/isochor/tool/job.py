# SPDX-License-Identifier: GPL-3.0-or-later
"""One modifier in one evaluation, and what is remembered of it between evaluations."""

from collections import Counter
from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.folding import Folding
from ..core.grid import Placing
from ..core.report import Report
from ..core.request import Request, Vertices
from ..core.solver import Outcome, Solver
from . import evaluated, pins
from .bound import BoundCache
from .chain import Chain
from .divided import Divided
from .drawn import Cuts
from .entered import Entered
from .lattice_weights import StiffnessCache

Key = tuple[int, int, str]
"""Session identifier of the object, identifier of the modifier in it, depsgraph mode."""


@dataclass
class Memory:
    """What one modifier keeps between frames in one mode."""

    solver: Solver = field(default_factory=Solver)
    faces: evaluated.Faces = field(default_factory=evaluated.Faces)
    own_positions: Vertices | None = None
    own_stamp: tuple[int, int] | None = None
    bound: BoundCache = field(default_factory=BoundCache)
    placing: Placing = field(default_factory=Placing)
    lattice_boxes: dict[int, evaluated.Box] = field(default_factory=dict)
    metric: NDArray[np.float64] | None = None
    edited: bool = False
    edited_stamp: tuple[int, int, float] | None = None
    written: Outcome | None = None
    asked: Request | None = None
    """Of the frame evaluated last; None where what was wrong left nothing to ask."""
    anchored: bool = False
    anchor: NDArray[np.float64] | None = None
    report: Report = field(default_factory=Report)
    cuts: Cuts = field(default_factory=Cuts)
    folding: Folding = field(default_factory=Folding)
    stiffness: StiffnessCache = field(default_factory=StiffnessCache)
    divided: Divided = field(default_factory=Divided)
    pinned: pins.Corners = field(default_factory=pins.Corners)

    @property
    def transform_before(self) -> NDArray[np.float64] | None:
        """The lattice's transform that this frame's is taken for where the two hardly differ: that of the frame before,
        or while frames must not depend on those before them that of one certain frame."""
        return self.anchor if self.anchored else self.solver.bound_transform


@dataclass(frozen=True)
class Job:
    """One modifier of one object in one evaluation."""

    obj: bpy.types.Object
    obj_evaluated: bpy.types.Object
    modifier: bpy.types.NodesModifier
    depsgraph: bpy.types.Depsgraph
    edits: Counter[int]
    entered: Entered
    before: Chain | None = None
    """The Volume Lattices right before this one, computed just now."""

    @property
    def mesh_edits(self) -> int:
        """Of the object's mesh, or other data."""
        return self.edits[self.obj.data.session_uid]

    @property
    def mode(self) -> str:
        return self.depsgraph.mode

    @property
    def key(self) -> Key:
        """Names the modifier in this session, across undo and renaming."""
        return self.obj.session_uid, self.modifier.persistent_uid, self.mode

    @property
    def evaluated_modifier(self) -> bpy.types.NodesModifier:
        """The copy with drivers and keys applied."""
        return self.obj_evaluated.modifiers[self.modifier.name]

    @property
    def slot(self) -> str:
        return str(self.modifier.persistent_uid)
