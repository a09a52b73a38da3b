# SPDX-License-Identifier: GPL-3.0-or-later
"""Ferrier's car as a scene: four lattices around it, tied; the front one crumples at a post, the rest keeps still
(bpy)."""

from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from models.car import FRONT, make_car
from models.materials import car_material
from models.model import Array
from models.model_object import model_object
from stage import set_stage, tint
from surface_measures import enclosed_volume, mesh_arrays
from volume_lattice import get_input, set_input

NAMES = ("Front", "Cabin", "Rear", "Boot")
ENDS = (-2.26, -0.86, 0.2, 1.1, 2.24)
"""Where the blocks meet along x."""
LOW, HIGH = (-1.0, 0.16), (1.0, 1.52)
"""(y, z) of all blocks. The wheels reach lower, and are no part of what the blocks hold."""
POINTS = {"Front": (11, 7, 7), "Cabin": (8, 7, 7), "Rear": (8, 7, 7), "Boot": (7, 7, 7)}
DEGREE = 3
HELD = 3
"""Layers of the front's points that its joint holds."""
HIT, STOPPED, BACK, LAST = 10, 14, 18, 24
"""Frames: the car meets the post, stands, has come back a little, the end."""
START, CRUSH, RETURN = 2.6, 0.62, 0.1
"""Lengths along x: how far off the car starts, how far it runs on, how far it comes back."""
AT = 0.36
"""Where the middle of the car is when it meets the post."""
BODY = "Body"
POST, POST_AT = (0.16, 1.25), -0.34
"""Radius and height of the post, and its place along y: in the way of the car's right."""
POST_COLOUR = (0.75, 0.5, 0.03)


class Crash:
    """The car, its lattices by name and its modifiers in stack order, in the scene that is open."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        set_stage(scene)
        self.model = make_car()
        self.car = model_object("Car", self.model, car_material())
        scene.collection.objects.link(self.car)
        group = self.car.vertex_groups.new(name=BODY)
        group.add(np.flatnonzero(self.model.values["wheel"] > 0.0).tolist(), 1.0, "REPLACE")
        # The front comes last: the last one of a row keeps the volume, and only its points may move for that.
        self.lattices = {name: self._block(name) for name in reversed(NAMES)}
        self.whole = enclosed_volume(*mesh_arrays(self.car.data))
        self._tie()
        self._crumple()
        self._drive()
        add_post(scene)
        scene.frame_start, scene.frame_end = 1, LAST
        scene.frame_set(1)

    @property
    def last(self) -> bpy.types.NodesModifier:
        """The modifier that keeps the volume."""
        return self.car.modifiers[-1]

    def put(self, **inputs: Any) -> None:
        """Sets inputs of the last modifier."""
        for name, value in inputs.items():
            set_input(self.last, name, value)
        bpy.context.view_layer.update()

    def moved(self) -> Array:
        """(V, 3) how far each vertex is from where it was modelled, in the car's own space."""
        seen: Any = self.car.evaluated_get(bpy.context.evaluated_depsgraph_get())
        now, rest = (mesh_arrays(mesh)[0].astype(np.float64) for mesh in (seen.data, self.car.data))
        return np.asarray(now - rest)

    def moved_behind(self) -> float:
        """The largest displacement of any vertex of the three blocks behind the front."""
        behind = mesh_arrays(self.car.data)[0][:, 0] > ENDS[1]
        return float(np.abs(self.moved()[behind]).max())

    def _block(self, name: str) -> bpy.types.Object:
        """One more Volume Lattice, its lattice put where it belongs."""
        select(self.car)
        if bpy.ops.isochor.add(resolution=POINTS[name], basis="BSPLINE") != {"FINISHED"}:
            raise RuntimeError(f"no Volume Lattice for {name}")
        modifier = self.car.modifiers[-1]
        modifier.name = name
        set_input(modifier, "Vertex Group", BODY)
        lattice = get_input(modifier, "Lattice")
        lattice.name = name
        number = NAMES.index(name)
        low, high = np.array([ENDS[number], *LOW]), np.array([ENDS[number + 1], *HIGH])
        counts = np.array(POINTS[name])
        size = (high - low) * (counts - 1) / (counts - DEGREE)
        lattice.matrix_world = Matrix.Translation(((low + high) / 2.0).tolist()) @ Matrix.Diagonal((*size, 1.0))
        lattice.parent = self.car
        bpy.context.view_layer.update()
        return lattice

    def _tie(self) -> None:
        select(*(self.lattices[name] for name in NAMES))
        if bpy.ops.isochor.tie_lattices(continuity="C1") != {"FINISHED"}:
            raise RuntimeError("the blocks could not be tied")

    def _crumple(self) -> None:
        lattice = self.lattices["Front"]
        lattice.shape_key_add(name="Basis")
        key = lattice.shape_key_add(name="Crumple")
        rest = np.array([tuple(point.co) for point in key.data])
        size, middle = np.array(lattice.scale), np.array(lattice.location)
        moved = (crumpled(rest * size + middle) - middle) / size
        layer = np.arange(len(rest)) % POINTS["Front"][0]
        moved = np.where(layer[:, None] < POINTS["Front"][0] - HELD, moved, rest)
        key.data.foreach_set("co", moved.astype(np.float32).reshape(-1))
        for frame, value in ((HIT, 0.0), (STOPPED, 1.0), (BACK, 0.94)):
            key.value = value
            key.keyframe_insert("value", frame=frame)

    def _drive(self) -> None:
        for frame, place in ((1, START), (HIT, 0.0), (STOPPED, -CRUSH), (BACK, RETURN - CRUSH), (LAST, RETURN - CRUSH)):
            self.car.location.x = AT + place
            self.car.keyframe_insert("location", index=0, frame=frame)


def crumpled(points: Array) -> Array:
    """Where places of the front go: a post drives a dent into it, and the bonnet rises in folds about that."""
    x, y, z = points.T
    depth = np.clip((ENDS[1] - 0.25 - x) / (ENDS[1] - 0.25 - ENDS[0]), 0.0, 1.3)
    inner = np.minimum(depth, 1.0)
    dent = np.exp(-(((y - POST_AT) / 0.5) ** 2))
    high = np.clip((z - 0.4) / 0.5, 0.0, 1.2)
    fold = np.sin(3.6 * np.pi * inner + 1.6 * (y - POST_AT))
    push = (0.14 + 0.62 * dent) * depth**1.3
    up = high * (0.2 * np.sin(np.pi * inner) * (0.3 + 0.9 * dent) + 0.09 * fold * inner * (0.4 + dent))
    out = 0.1 * np.sin(np.pi * inner) * y + 0.06 * fold * y * inner - 0.1 * inner * dent * (y - POST_AT)
    return np.column_stack([x + push, y + out, z + up - 0.06 * depth * (1.0 - np.minimum(high, 1.0))])


def add_post(scene: bpy.types.Scene) -> bpy.types.Object:
    """A post in the way of the car's right."""
    radius, height = POST
    bpy.ops.mesh.primitive_cylinder_add(radius=radius, depth=height, vertices=48)
    post = bpy.context.object
    post.name = "Post"
    post.location = (AT + FRONT - radius, POST_AT, height / 2.0)
    bevel = post.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.03, 3
    post.data.materials.append(tint("Post", POST_COLOUR))
    return post


def select(*objects: bpy.types.Object) -> None:
    """Selects these alone; the first is active."""
    bpy.ops.object.select_all(action="DESELECT")
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]
