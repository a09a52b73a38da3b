# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 1, bouncing: a casket falls flat on the ground; corrected sideways it spreads and keeps its volume."""

from collections.abc import Iterator

import bpy
from figure import HORIZONTAL, Figure, alone, corrected
from figure_stage import View
from gallery_scene import Staged
from gallery_tile import Tile
from lattice_animation import shape_lattice
from models.casket import make_casket
from models.materials import casket_material
from models.model_object import model_object

NAME = "figure-1"
COLUMNS = 4
LOSSES = {25: 0.28, 30: 0.51, 35: 0.64}
"""Frame to share of the volume that the lattice alone loses, as in the paper."""
LANDS, LAST, APEX = 20, 35, 0.75
VIEW = View(turn=32.0, rise=14.0, height=1.0, distance=10.6, size=(392, 316))


def build(scene: bpy.types.Scene) -> Figure:
    """The fall and the squash, frames 1 to 35."""
    staged = Staged(scene, model_object("Casket", make_casket(), casket_material()), (6, 6, 6))
    shape_lattice(staged.object, staged.lattice)
    _key_fall(staged)
    _key_squash(staged.lattice)
    scene.frame_end = LAST
    return Figure(NAME, staged, (alone(), corrected("horizontal", HORIZONTAL)), LAST)


def pictures(figure: Figure) -> Iterator[Tile]:
    """Above the lattice alone, below corrected."""
    for variant in figure.variants:
        for frame in (1, *LOSSES):
            yield figure.tile(variant, frame, f"frame {frame}, {variant.name}")


def _key_fall(staged: Staged) -> None:
    """Casket and lattice hang on an empty, which falls."""
    rig = bpy.data.objects.new("Fall", None)
    bpy.context.scene.collection.objects.link(rig)
    for carried in (staged.object, staged.lattice):
        carried.parent = rig
    for frame, height in ((1, APEX), (LANDS, 0.0)):
        rig.location.z = height
        rig.keyframe_insert("location", index=2, frame=frame)


def _key_squash(lattice: bpy.types.Object) -> None:
    """The lattice alone loses the share that each marked frame names: linear in the key's value."""
    key = lattice.data.shape_keys.key_blocks["Squash"]
    deepest = max(LOSSES.values())
    for frame, loss in {LANDS: 0.0, **LOSSES}.items():
        key.value = loss / deepest
        key.keyframe_insert("value", frame=frame)
