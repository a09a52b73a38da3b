# SPDX-License-Identifier: GPL-3.0-or-later
"""A model of Bezier patches, of which only the control points are deformed; its volume is that of its tessellation."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import Array
from figure_lattice import turned
from figure_stage import View, set_view
from gallery_scene import clear_stage, draw_lines, draw_paths
from gallery_tile import Tile
from models.elephant import make_elephant, paint
from models.materials import elephant_material
from models.model import Model
from models.model_object import model_object
from models.patch_model import bernstein
from stage import set_stage
from surface_measures import enclosed_volume

NAME = "patches"
COLUMNS = 3
LEVEL = 8
SHAPE = (4, 3, 4)
PLACE = np.array([-0.45, 0.0, 0.0])
BORDER = 0.008
"""Radius of the drawn edges of patches, in scene units."""
VIEW = View(turn=28.0, rise=12.0, height=1.12, distance=14.2, size=(520, 400))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """At rest with the edges of its patches, under the lattice alone, and with the volume."""
    deformed = PatchDeformation()
    elephant = make_elephant()
    count = f"{len(elephant.patches)} patches, {len(elephant.points)} points"
    stage(scene, deformed.rest, deformed, elephant.points)
    yield deformed.tile(count, promised=True)
    for share, caption in ((0.0, "its points under the lattice alone"), (1.0, "its points moved, with volume")):
        surface, points, control = deformed.shaped(share)
        stage(scene, surface, deformed, points)
        draw_lines("Lattice", control + PLACE)
        yield deformed.tile(caption, promised=share > 0.0)


class PatchDeformation:
    """The elephant's control points bound to a lattice, with its tessellation to measure volumes on."""

    def __init__(self) -> None:
        import isochor

        elephant = make_elephant()
        found = isochor.Patches(elephant.points, elephant.patches.transpose(0, 2, 1)).tessellate(LEVEL)
        self.surface, self.triangles = found.surface, found.triangles
        self.rest = self.surface.apply(elephant.points)
        self.whole = enclosed_volume(self.rest, self.triangles)
        self.lattice = isochor.Lattice.around(elephant.points, shape=SHAPE)
        self.binding = self.lattice.bind(elephant.points, self.triangles, surface=self.surface)

    def shaped(self, share: float) -> tuple[Array, Array, Array]:
        """The surface's vertices (T, 3), its control points (K, 3) and those of the lattice (nw, nv, nu, 3), pressed,
        this share of the lost volume given back."""
        control = pressed(self.lattice.rest)
        result = self.binding.preserve(control, axes=(1.0, 1.0, 0.0), amount=share)
        return result.surface, result.vertices, control.transpose(2, 1, 0, 3)

    def tile(self, caption: str, promised: bool) -> Tile:
        """The picture of what is on the stage."""
        return Tile(caption, "Elephant", self.whole, self.whole if promised else None)


def pressed(control: Array) -> Array:
    """The lattice's control points (nu, nv, nw, 3): lower, and the trunk's end rolled up."""
    moved = control.copy()
    moved[..., 2] *= 0.62
    pivot = moved[1, 0, 2]
    share = np.array([0.0, 0.0, 0.5, 1.0])[:, None, None]
    along, up = turned(moved[..., 0] - pivot[0], moved[..., 2] - pivot[2], 0.7 * share)
    moved[..., 0], moved[..., 2] = pivot[0] + along, pivot[2] + up
    return moved


def stage(scene: bpy.types.Scene, surface: Array, deformed: PatchDeformation, points: Array) -> None:
    """The tessellated elephant with the edges of its patches."""
    clear_stage()
    set_stage(scene)
    model = Model(surface, deformed.triangles, paint(deformed.rest))
    elephant = model_object("Elephant", model, elephant_material())
    elephant.location = PLACE
    scene.collection.objects.link(elephant)
    draw_paths("Edges", borders(points) + PLACE, BORDER)
    set_view(scene, VIEW)


def borders(points: Array) -> Array:
    """Paths (n, 9, 3) along the edges of patches whose control points (K, 3) have been moved."""
    edges = {}
    for patch in make_elephant().patches:
        for turn in range(4):
            row = np.rot90(patch, turn)[0]
            edges[min(tuple(row.tolist()), tuple(row[::-1].tolist()))] = row
    return np.einsum("ti,eic->etc", bernstein(np.linspace(0.0, 1.0, 9)), points[np.array(list(edges.values()))])
