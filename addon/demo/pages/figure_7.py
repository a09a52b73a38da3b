# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 7, the ear of a character: a pin pulls its tip, without a correction, with one everywhere, and with a local
one that leaves the head alone."""

from collections.abc import Iterator

import bmesh
import bpy
import numpy as np
from blender_session import DemoError
from figure import GENERAL, Array, Figure, Variant, alone, corrected
from figure_stage import View
from gallery_scene import Staged, draw_lines
from gallery_tile import Tile
from models.goblin import make_goblin, off_ear
from models.materials import goblin_material, moved_material
from models.model_object import model_object
from stage import tint

NAME = "figure-7"
COLUMNS = 4
LAST = 13
TIP = (1.15, 0.055, 2.17)
"""Near the vertex that is pinned: the tip of the ear."""
PULL = (0.15, -0.15, 0.7)
FALLOFF = 0.4
"""Distance from the pin in which a control point becomes e times as hard to move."""
AWAY = 0.4
"""Vertices farther than this from the middle of the ear are the rest of the head."""
VIEW = View(turn=24.0, rise=14.0, height=1.3, distance=9.4, size=(392, 392))
INNER = (slice(1, -1),) * 3
"""Of the lattice's points those in and on the box of the head: a layer more stands around them."""
PIN_RADIUS, PIN_COLOUR = 0.045, (0.8, 0.03, 0.02)


def build(scene: bpy.types.Scene) -> Figure:
    """The head, the tip of one ear pulled from frame 1 to 13."""
    goblin = model_object("Goblin", make_goblin(), goblin_material())
    staged = Staged(scene, goblin, (6, 5, 6), margin=0.02)
    pin = add_pin(staged)
    start = pin.location.copy()
    for frame, share in ((1, 0.0), (LAST, 1.0)):
        pin.location = [place + share * way for place, way in zip(start, PULL)]
        pin.keyframe_insert("location", frame=frame)
    scene.frame_end = LAST
    rest = np.array([vertex.co for vertex in goblin.data.vertices])
    away = off_ear(rest) > AWAY
    tip = int(np.linalg.norm(rest - start, axis=1).argmin())

    def stillness(positions: Array, plain: Array) -> dict[str, float]:
        """How far the rest of the head moves at most, in sizes of the head; how far the tip misses its pin."""
        moved = np.linalg.norm(positions - rest, axis=1)[away].max() / staged.size
        return {"head moved": float(moved), "pin missed": float(np.linalg.norm(positions[tip] - pin.location))}

    variants = (
        alone(Falloff=0.0),
        corrected("pin, general correction", GENERAL, Falloff=0.0),
        corrected("pin, local correction", GENERAL, Falloff=FALLOFF),
    )
    return Figure(NAME, staged, (Variant("pin alone", variants[0].inputs), *variants[1:]), LAST, stillness)


def add_pin(staged: Staged) -> bpy.types.Object:
    """The empty that pins the tip of the ear."""
    if bpy.ops.isochor.add_pin(where="POINT", point=TIP, snap=True) != {"FINISHED"}:
        raise DemoError("isochor.add_pin did not finish: see its message above")
    (pin,) = staged.value("Pins").all_objects
    return pin


def pictures(figure: Figure) -> Iterator[Tile]:
    """At rest and the three variants, then the same coloured by how far each vertex has moved, in its lattice."""
    draw_pin(figure.staged)
    states = ((figure.variants[0], 1, "at rest"), *((variant, LAST, variant.name) for variant in figure.variants))
    for variant, frame, caption in states:
        yield figure.tile(variant, frame, caption, head_words)
    for variant, frame, _ in states:
        paint_moved(figure, figure.show(variant, frame))
        lines = draw_lines("Lattice Lines", np.asarray(figure.staged.report.control)[INNER])
        yield figure.tile(variant, frame, "how far it has moved", band_words)
        bpy.data.objects.remove(lines)


def paint_moved(figure: Figure, positions: Array) -> None:
    """Colours the head by how far each vertex is from its place at rest, in sizes of the head."""
    mesh = figure.staged.object.data
    rest = np.array([vertex.co for vertex in mesh.vertices])
    attribute = mesh.attributes.get("moved") or mesh.attributes.new("moved", "FLOAT", "POINT")
    moved = np.linalg.norm(positions - rest, axis=1) / figure.staged.size
    attribute.data.foreach_set("value", moved.astype(np.float32))
    mesh.materials[0] = bpy.data.materials.get("Moved") or moved_material()
    mesh.update()


def band_words(found: dict[str, float]) -> str:
    """What the colours mean."""
    return "grey < 1, yellow < 2, orange < 5, red < 10 %"


def head_words(found: dict[str, float]) -> str:
    """How far the rest of the head moved."""
    return f"head moved up to {100.0 * found['head moved']:.1f} % of its size"


def draw_pin(staged: Staged) -> None:
    """A bead where the pin is, for renders show no empties."""
    (pin,) = staged.value("Pins").all_objects
    mesh = bpy.data.meshes.new("Bead")
    builder = bmesh.new()
    bmesh.ops.create_icosphere(builder, subdivisions=3, radius=PIN_RADIUS)
    builder.to_mesh(mesh)
    builder.free()
    mesh.shade_smooth()
    mesh.materials.append(tint("Bead", PIN_COLOUR))
    bead = bpy.data.objects.new("Bead", mesh)
    bpy.context.scene.collection.objects.link(bead)
    bead.parent = pin
