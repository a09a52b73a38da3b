# SPDX-License-Identifier: GPL-3.0-or-later
"""Rational weights: one point that pulls the harder the heavier it is, and a bar bent into an exact half circle."""

from collections.abc import Iterator
from math import pi

import bpy
import numpy as np
from column import HEIGHT, make_column
from figure import Array
from figure_stage import View, set_view
from gallery_scene import Staged, clear_stage, draw_lattice, draw_paths, evaluated_points
from gallery_tile import Tile
from mathutils import Vector
from models.cube_grid import cube_grid
from models.materials import sign_material
from models.model import Model
from models.model_object import model_object
from surface_measures import mesh_arrays

NAME = "weights"
COLUMNS = 3
GROUP = "Heavy"
PULL = 0.9
"""How far the middle point of the slab's top is lifted, in scene units."""
WEIGHTS = (1.0, 5.0, 50.0)
SLIM, TALL = 0.4, 1.5
"""Factors on the column's width and height."""
LIGHT = 1.0 / 3.0
"""Weight of the two inner layers of a cubic half circle, where the outer ones weigh 1."""
SLAB_VIEW = View(turn=25.0, rise=16.0, height=0.75, distance=9.5, size=(520, 350))
BAR_VIEW = View(turn=0.0, rise=8.0, height=1.35, distance=12.5, size=(520, 350))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """A point of three weights, then the bar at rest, with equal weights, and with those of a circle."""
    for weight in WEIGHTS:
        staged = pulled(scene, weight)
        yield staged.tile(f"the middle point weighs {weight:g}", note=f"lifts the slab by {lift(staged):.2f} of {PULL}")
    staged = bar(scene)
    draw_lattice(staged.lattice)
    yield staged.tile("a straight bar")
    for heaviest, caption in ((1.0, "bent, all weights 1"), (LIGHT, "bent, inner weights 1/3: a half circle")):
        staged = bent_bar(scene, heaviest)
        draw_circle()
        yield staged.tile(caption, promised=False, note=f"off the circle by {off_circle(staged):.1e}")


def pulled(scene: bpy.types.Scene, weight: float) -> Staged:
    """A slab with one point of its lattice lifted."""
    clear_stage()
    points, triangles = cube_grid(48)
    points = points * (1.1, 1.1, 0.22) + (0.0, 0.0, 0.22)
    slab = Model(points, triangles, {"across": np.sin(6.0 * pi * points[:, 0]) * np.sin(6.0 * pi * points[:, 1])})
    staged = Staged(scene, model_object("Slab", slab, sign_material()), (5, 5, 2), basis="BERNSTEIN", margin=0.0)
    set_view(scene, SLAB_VIEW)
    middle = 25 + 12
    point = staged.lattice.data.points[middle]
    point.co_deform.z += PULL / staged.lattice.scale.z
    weigh(staged, [middle], weight)
    place = staged.lattice.matrix_world @ point.co_deform
    draw_paths("Pulled", [[place, place - Vector((0.0, 0.0, 0.001))]], radius=0.06)
    return staged


def lift(staged: Staged) -> float:
    """How high the lattice alone lifts the slab's middle."""
    staged.put(Preserve=0.0)
    moved = evaluated_points(staged.object) - mesh_arrays(staged.object.data)[0]
    staged.put(Preserve=1.0)
    return float(moved[:, 2].max())


def weigh(staged: Staged, points: list[int], weight: float) -> None:
    """Gives points of the lattice a weight of their own."""
    staged.lattice.vertex_groups.new(name=GROUP).add(points, 1.0, "REPLACE")
    staged.put(Weights=GROUP, Heaviest=weight)


def bar(scene: bpy.types.Scene) -> Staged:
    """A slim column in a lattice of four layers, to be bent towards +x."""
    clear_stage()
    column = make_column()
    column.scale = (SLIM, SLIM, TALL)
    staged = Staged(scene, column, (2, 2, 4), basis="BERNSTEIN", margin=0.0)
    set_view(scene, BAR_VIEW)
    return staged


def bent_bar(scene: bpy.types.Scene, weight: float) -> Staged:
    """The bar bent, its inner layers of that weight, without correction: a half circle needs none."""
    staged = bar(scene)
    to_own = staged.lattice.matrix_world.inverted()
    for number, point in enumerate(staged.lattice.data.points):
        place = staged.lattice.matrix_world @ point.co
        point.co_deform = to_own @ Vector(bent_point(np.array(place), number // 4))
    weigh(staged, list(range(4, 12)), weight)
    staged.put(Preserve=0.0, Outside="Extend")
    for carried in (staged.object, staged.lattice):
        carried.location.x -= RADIUS
    return staged


RADIUS = HEIGHT * TALL / pi
"""Of the half circle into which the bar's middle line is bent, in scene units: it stays as long as it is."""


def bent_point(place: Array, layer: int) -> Array:
    """Where a control point must go so that the lattice *moves* the bar onto the circle: with weights w, what moves it
    by sum(w B d) / sum(w B) takes x to sum(w B P) / sum(w B), P the control points of a circle's cubic, where
    w d = w P - (coefficients of x sum(w B)); the height's are H (0, 1/3, 0, 1)."""
    weight = (1.0, LIGHT, LIGHT, 1.0)[layer]
    radius = RADIUS - place[0]
    x = place[0] if layer < 2 else 2.0 * RADIUS - place[0]
    z = 2.0 * radius if 0 < layer < 3 else 0.0
    up = HEIGHT * TALL * (0.0, 1.0 / 3.0, 0.0, 1.0)[layer]
    return np.array([x, place[1], place[2] + z - up / weight])


def off_circle(staged: Staged) -> float:
    """How far any point of the bar is from the circle that it must be on, in scene units."""
    scale = np.array(staged.object.scale)
    rest = mesh_arrays(staged.object.data)[0] * scale
    found = evaluated_points(staged.object) * scale
    away = np.hypot(found[:, 0] - RADIUS, found[:, 2])
    return float(np.abs(away - (RADIUS - rest[:, 0])).max())


def draw_circle() -> None:
    """The half circles that the front edges must follow."""
    around = np.linspace(0.0, pi, 65)
    front = -SLIM / 2.0 - 0.01
    for radius in (RADIUS - SLIM / 2.0, RADIUS + SLIM / 2.0):
        path = np.stack([radius * np.cos(around), np.full(65, front), radius * np.sin(around)], axis=1)
        draw_paths("Circle", [path])
