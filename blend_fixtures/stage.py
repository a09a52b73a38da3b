# SPDX-License-Identifier: GPL-3.0-or-later
"""Ground, light, camera, materials and render settings of the bouncing ball (bpy)."""

import math
from typing import TypeAlias

import bpy
from ball_surface import BAND_HALF_WIDTH, PLUG_RADIUS
from mathutils import Vector

Triple = tuple[float, float, float]
Colour = Triple
Input: TypeAlias = bpy.types.NodeSocket | Colour | float

RESOLUTION = (392, 328)
SAMPLES = 10
GROUND_SIZE = 60.0
TILE = 0.5

CREAM = (0.86, 0.78, 0.62)
CORAL = (0.78, 0.115, 0.055)
CORAL_DIMPLE = (0.48, 0.045, 0.025)
TEAL = (0.03, 0.27, 0.33)
TEAL_DIMPLE = (0.012, 0.13, 0.18)
INK = (0.018, 0.030, 0.070)


class Shader:
    """A material's node tree with the few node kinds used here; every method returns an output socket."""

    def __init__(self, name: str) -> None:
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.principled = self.tree.nodes["Principled BSDF"]

    def _fill(self, socket: bpy.types.NodeSocket, value: Input) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1.0) if isinstance(value, tuple) else value

    def attribute(self, name: str) -> bpy.types.NodeSocket:
        node = self.tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs["Fac"]

    def below(self, value: bpy.types.NodeSocket, limit: float, softness: float = 0.004) -> bpy.types.NodeSocket:
        """1 where `value` < `limit`, 0 above, with an edge `softness` wide."""
        node = self.tree.nodes.new("ShaderNodeMapRange")
        self._fill(node.inputs["Value"], value)
        edge = {"From Min": limit - softness, "From Max": limit + softness, "To Min": 1, "To Max": 0}
        for name, number in edge.items():
            node.inputs[name].default_value = number
        return node.outputs["Result"]

    def absolute(self, value: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = "ABSOLUTE"
        self._fill(node.inputs[0], value)
        return node.outputs[0]

    def mix(self, share: bpy.types.NodeSocket, first: Input, second: Input) -> bpy.types.NodeSocket:
        """Colour `first` where `share` is 0 and `second` where it is 1."""
        node = self.tree.nodes.new("ShaderNodeMix")
        node.data_type = "RGBA"
        for socket, value in zip((node.inputs[0], node.inputs[6], node.inputs[7]), (share, first, second)):
            self._fill(socket, value)
        return node.outputs[2]

    def checker(self, first: Colour, second: Colour, tile: float) -> bpy.types.NodeSocket:
        position = self.tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
        node = self.tree.nodes.new("ShaderNodeTexChecker")
        self._fill(node.inputs["Vector"], position)
        self._fill(node.inputs["Color1"], first)
        self._fill(node.inputs["Color2"], second)
        node.inputs["Scale"].default_value = 1 / tile
        return node.outputs["Color"]

    def finish(self, colour: bpy.types.NodeSocket, roughness: float, coat: float = 0.0) -> bpy.types.Material:
        self._fill(self.principled.inputs["Base Color"], colour)
        self.principled.inputs["Roughness"].default_value = roughness
        self.principled.inputs["Coat Weight"].default_value = coat
        return self.material


def make_ball_material() -> bpy.types.Material:
    """Rubber coloured by the ball's attributes latitude, ink, dimple and groove (see ball_surface)."""
    shader = Shader("Ball")
    latitude, dimple = shader.attribute("latitude"), shader.attribute("dimple")
    dimpled = shader.below(dimple, -0.012, softness=0.02)
    upper = shader.mix(dimpled, CORAL, CORAL_DIMPLE)
    lower = shader.mix(dimpled, TEAL, TEAL_DIMPLE)
    caps = shader.mix(shader.below(latitude, 0.0), upper, lower)
    distance = shader.absolute(latitude)
    band = shader.mix(shader.below(distance, BAND_HALF_WIDTH), caps, CREAM)
    plugs = shader.mix(shader.below(distance, math.pi / 2 - PLUG_RADIUS), CREAM, band)
    seams = shader.mix(shader.below(shader.attribute("groove"), 0.0), plugs, INK)
    return shader.finish(shader.mix(shader.below(shader.attribute("ink"), 0.0), seams, INK), roughness=0.38, coat=0.15)


def make_striped_material() -> bpy.types.Material:
    """Rubber in stripes by the attributes around and up: another colour where each is negative."""
    shader = Shader("Stripes")
    around, up = (shader.below(shader.attribute(name), 0.0, softness=0.03) for name in ("around", "up"))
    light, dark = shader.mix(around, CORAL, CREAM), shader.mix(around, INK, TEAL)
    return shader.finish(shader.mix(up, light, dark), roughness=0.4, coat=0.15)


def tint(name: str, colour: Colour) -> bpy.types.Material:
    """Plain, dull material of one colour."""
    shader = Shader(name)
    shader._fill(shader.principled.inputs["Base Color"], colour)
    shader.principled.inputs["Roughness"].default_value = 0.8
    return shader.material


def _add_ground() -> bpy.types.Object:
    mesh = bpy.data.meshes.new("Ground")
    half = GROUND_SIZE / 2
    mesh.from_pydata([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)])
    shader = Shader("Ground")
    mesh.materials.append(shader.finish(shader.checker((0.62, 0.60, 0.57), (0.47, 0.455, 0.44), TILE), roughness=0.9))
    return bpy.data.objects.new("Ground", mesh)


def _add_sun(
    name: str, direction: Triple, softness_degrees: float, strength: float, colour: Colour
) -> bpy.types.Object:
    light = bpy.data.lights.new(name, "SUN")
    light.angle, light.energy, light.color = math.radians(softness_degrees), strength, colour
    lamp = bpy.data.objects.new(name, light)
    lamp.location = -4 * Vector(direction)
    lamp.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    return lamp


def _add_camera(location: Triple, target: Triple, lens: float) -> bpy.types.Object:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = lens
    camera.location = location
    camera.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    return camera


def _set_world(scene: bpy.types.Scene) -> None:
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.70, 0.82, 1.0, 1)
    background.inputs["Strength"].default_value = 0.62
    scene.world = world


def _denoise(cycles: bpy.types.PropertyGroup) -> None:
    """Denoises renders, where this Blender was built with a denoiser: some distributions' are not."""
    try:
        cycles.denoiser = "OPENIMAGEDENOISE"
    except TypeError:
        cycles.use_denoising = False
        return
    cycles.use_denoising = True
    cycles.denoising_quality = "FAST"  # with no prefilter: a third of the time, as clean
    cycles.denoising_prefilter = "NONE"
    cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"


def set_stage(scene: bpy.types.Scene) -> None:
    """Adds ground, lights, camera and world to `scene` and sets it up for a quick, clean Cycles render."""
    objects = (
        _add_ground(),
        _add_sun("Key", (0.45, 0.50, -0.75), softness_degrees=14, strength=2.6, colour=(1.0, 0.95, 0.88)),
        _add_camera((0.0, -11.5, 3.9), (0, 0, 1.21), lens=95),
    )
    for item in objects:
        scene.collection.objects.link(item)
    scene.camera = objects[-1]
    _set_world(scene)
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = RESOLUTION
    render.resolution_percentage = 100
    render.image_settings.file_format = "PNG"
    render.image_settings.color_mode = "RGB"
    render.use_lock_interface = True
    scene.cycles.device = "CPU"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = True
    scene.cycles.adaptive_threshold = 0.05
    scene.cycles.max_bounces = 2
    _denoise(scene.cycles)
    scene.view_settings.view_transform = "Standard"
