# SPDX-License-Identifier: GPL-3.0-or-later
"""What the models are painted with: colours that meet where a value of the model is 0 (bpy)."""

import bpy
from stage import CORAL, CREAM, INK, Shader

LACQUER, SUNKEN_LACQUER, GOLD = (0.62, 0.045, 0.03), (0.3, 0.014, 0.014), (0.83, 0.5, 0.13)
GLAZE, CLAY, LINING = (0.04, 0.3, 0.36), (0.62, 0.34, 0.2), (0.86, 0.8, 0.68)
SKIN, PALE, PINK = (0.2, 0.36, 0.13), (0.42, 0.5, 0.22), (0.62, 0.24, 0.2)
PUPIL, EYE = (0.02, 0.02, 0.025), (0.85, 0.84, 0.8)
HIDE, EAR_PINK = (0.23, 0.29, 0.38), (0.72, 0.36, 0.32)
MOVED = ((0.01, (0.6, 0.6, 0.58)), (0.02, (0.85, 0.72, 0.2)), (0.05, (0.85, 0.35, 0.05)), (0.1, (0.65, 0.06, 0.03)))
"""What moved less than each limit, in sizes of the model, and its colour."""
MOVED_MOST = (0.2, 0.01, 0.03)
PAINT, TRIM, GLASS = (0.03, 0.2, 0.34), (0.02, 0.022, 0.026), (0.025, 0.035, 0.05)
LAMP, TAIL, TYRE, RIM = (0.9, 0.85, 0.7), (0.6, 0.02, 0.015), (0.018, 0.018, 0.02), (0.55, 0.56, 0.58)
STEEL, HANDLE, BAND = (0.2, 0.22, 0.25), (0.86, 0.3, 0.03), (0.03, 0.035, 0.05)


def casket_material() -> bpy.types.Material:
    """Red lacquer with gilt carving."""
    shader = Shader("Casket")
    lacquer = shader.mix(shader.below(shader.attribute("sunken"), 0.0, softness=0.01), LACQUER, SUNKEN_LACQUER)
    gilt = shader.below(shader.attribute("gold"), -0.002, softness=0.006)
    return shader.finish(shader.mix(gilt, lacquer, GOLD), roughness=0.34, coat=0.3)


def cup_material() -> bpy.types.Material:
    """Clay, dipped in glaze, light inside."""
    shader = Shader("Cup")
    outside = shader.mix(shader.below(shader.attribute("glaze"), 0.0, softness=0.006), CLAY, GLAZE)
    lined = shader.below(shader.attribute("lining"), 0.0, softness=0.006)
    return shader.finish(shader.mix(lined, outside, LINING), roughness=0.22, coat=0.5)


def screwdriver_material() -> bpy.types.Material:
    """Steel and a bright handle with a dark band."""
    shader = Shader("Screwdriver")
    handle = shader.mix(shader.below(shader.attribute("band"), 0.0), HANDLE, BAND)
    held = shader.below(shader.attribute("handle"), 0.0)
    return shader.finish(shader.mix(held, STEEL, handle), roughness=0.3, coat=0.2)


def cube_material() -> bpy.types.Material:
    """A chequer."""
    shader = Shader("Cube")
    return shader.finish(shader.mix(shader.below(shader.attribute("field"), 0.0, 0.02), CREAM, CORAL), 0.4, 0.15)


def car_material() -> bpy.types.Material:
    """Lacquer, dark glass, lamps, black trim, tyres with bright rims."""
    shader = Shader("Car")
    colour = shader.mix(shader.below(shader.attribute("trim"), 0.0, softness=0.012), PAINT, TRIM)
    parts = (("glass", GLASS), ("lamp", LAMP), ("tail", TAIL), ("tyre", TYRE), ("rim", RIM))
    for name, part in parts:
        colour = shader.mix(shader.below(shader.attribute(name), 0.0, softness=0.012), colour, part)
    return shader.finish(colour, roughness=0.28, coat=0.6)


def goblin_material() -> bpy.types.Material:
    """Green skin, pink inside the ears, bright eyes."""
    shader = Shader("Goblin")
    skin = shader.mix(shader.below(shader.attribute("muzzle"), 0.0, softness=0.05), SKIN, PALE)
    for name, colour in (("inner_ear", PINK), ("nose", PINK), ("eye", EYE), ("pupil", PUPIL)):
        skin = shader.mix(shader.below(shader.attribute(name), 0.0, softness=0.008), skin, colour)
    return shader.finish(skin, roughness=0.35, coat=0.2)


def moved_material() -> bpy.types.Material:
    """Bands by the attribute moved: from below each limit of MOVED to above the last."""
    shader = Shader("Moved")
    moved = shader.attribute("moved")
    colour = shader.mix(shader.below(moved, 0.0), MOVED_MOST, MOVED_MOST)
    for limit, band in reversed(MOVED):
        colour = shader.mix(shader.below(moved, limit, softness=0.0005), colour, band)
    return shader.finish(colour, roughness=0.6)


def elephant_material() -> bpy.types.Material:
    """Grey hide and a red cloth with a golden trim."""
    shader = Shader("Elephant")
    colour = shader.mix(shader.below(shader.attribute("cloth"), 0.0), HIDE, CORAL)
    for name, paint in (("trim", GOLD), ("ear", EAR_PINK), ("tuft", INK), ("eye", INK)):
        colour = shader.mix(shader.below(shader.attribute(name), 0.0, softness=0.006), colour, paint)
    return shader.finish(colour, roughness=0.38, coat=0.15)


def sign_material() -> bpy.types.Material:
    """Enamel in stripes."""
    shader = Shader("Sign")
    return shader.finish(shader.mix(shader.below(shader.attribute("across"), 0.0, 0.05), CORAL, GOLD), 0.3, 0.3)
