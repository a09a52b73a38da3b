# SPDX-License-Identifier: GPL-3.0-or-later
"""Blending of poses: three shape keys of one lattice, each alone and mixed, the volume kept in all."""

from collections.abc import Iterator

import bpy
import numpy as np
from figure import Array
from figure_lattice import turned
from figure_stage import View, set_view
from gallery_scene import Staged, draw_lattice
from gallery_tile import Tile
from models.elephant import elephant_mesh
from models.materials import elephant_material
from models.model_object import model_object

NAME = "poses"
COLUMNS = 3
LEVEL = 8
RESOLUTION = (9, 5, 6)
NECK = np.array([0.35, 0.0, 1.75])
"""What the head turns about, in the elephant's own space."""
FORWARD = 1.1
"""Over how much length in front of the neck the turn grows."""
MIXES = (
    ("at rest", (0.0, 0.0, 0.0)),
    ("Crouch 1", (1.0, 0.0, 0.0)),
    ("Trumpet 1", (0.0, 1.0, 0.0)),
    ("Look 1", (0.0, 0.0, 1.0)),
    ("Crouch 0.6 + Trumpet 1", (0.6, 1.0, 0.0)),
    ("Crouch 0.5 + Trumpet 0.6 + Look 0.7", (0.5, 0.6, 0.7)),
)
"""Caption and values of the three keys."""
VIEW = View(turn=28.0, rise=12.0, height=1.36, distance=16.0, size=(520, 400))


def tiles(scene: bpy.types.Scene) -> Iterator[Tile]:
    """At rest in the lattice, each pose alone, then two mixtures."""
    staged = posed(scene)
    lines = draw_lattice(staged.lattice)
    for caption, values in MIXES:
        mix(staged, values)
        yield staged.tile(caption)
        lines.hide_render = True


def posed(scene: bpy.types.Scene) -> Staged:
    """The elephant in a lattice with three shape keys."""
    elephant = model_object("Elephant", elephant_mesh(LEVEL), elephant_material())
    elephant.location.x = -0.45
    staged = Staged(scene, elephant, RESOLUTION, margin=0.0)
    set_view(scene, VIEW)
    staged.lattice.shape_key_add(name="Basis")
    to_own = elephant.matrix_world.inverted() @ staged.lattice.matrix_world
    scale, place = np.array(to_own.to_scale()), np.array(to_own.translation)
    for name, moved in (("Crouch", crouch), ("Trumpet", trumpet), ("Look", look)):
        key = staged.lattice.shape_key_add(name=name, from_mix=False)
        key.value = 0.0
        rest = np.array([point.co for point in key.data], dtype=np.float64)
        shaped = (moved(rest * scale + place) - place) / scale
        key.data.foreach_set("co", shaped.astype(np.float32).reshape(-1))
    return staged


def mix(staged: Staged, values: tuple[float, ...]) -> None:
    """Sets the keys' values."""
    for key, value in zip(staged.lattice.data.shape_keys.key_blocks[1:], values):
        key.value = value
    bpy.context.view_layer.update()


def crouch(places: Array) -> Array:
    """Lower, most at the rump."""
    x, y, z = places.T
    return np.stack([x, y, z * (0.55 + 0.12 * (x + 1.6) / 2.0)], axis=1)


def trumpet(places: Array) -> Array:
    """Head and trunk thrown up."""
    x, y, z = places.T
    along, up = turned(x - NECK[0], z - NECK[2], 1.25 * share(x))
    return np.stack([NECK[0] + along, y, NECK[2] + up], axis=1)


def look(places: Array) -> Array:
    """The head turned towards the onlooker."""
    x, y, z = places.T
    along, aside = turned(x - NECK[0], y, -1.0 * share(x))
    return np.stack([NECK[0] + along, aside, z], axis=1)


def share(x: Array) -> Array:
    """Of the whole turn, from 0 at the neck to 1."""
    way = np.clip((x - NECK[0] + 0.2) / FORWARD, 0.0, 1.0)
    eased: Array = way**2 * (3.0 - 2.0 * way)
    return eased
