# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend of the overlay: a ramp of colours with the displacements at its ends, at the foot of the 3D View."""

import blf
import bpy
import numpy as np

from ..core.isolines import RAMP
from . import overlay_batches, words

TITLE = "Moved by the correction"
WIDTH, HEIGHT, FOOT = 160.0, 8.0, 34.0
"""Pixels at interface scale 1: the ramp's size, and its distance from the foot of the view."""


def draw(context: bpy.types.Context, largest: float) -> None:
    """Draws it in the middle of the part of the view that no sidebar covers; ``largest``: world units of the last
    colour."""
    scale = context.preferences.system.ui_scale
    left, right = free_span(context.area, context.region)
    start = (left + right - WIDTH * scale) / 2.0
    foot = FOOT * scale
    _ramp(start, foot, WIDTH * scale, HEIGHT * scale)
    settings = context.scene.unit_settings
    ends = [written(value, settings) for value in (0.0, largest)]
    colour = (*context.preferences.themes[0].view_3d.space.text_hi, 1.0)
    _text(words.shown(TITLE), start, foot + 13.0 * scale, scale, colour, 0.0)
    _text(ends[0], start, foot - 15.0 * scale, scale, colour, 0.0)
    _text(ends[1], start + WIDTH * scale, foot - 15.0 * scale, scale, colour, 1.0)


def free_span(area: bpy.types.Area, region: bpy.types.Region) -> tuple[float, float]:
    """First and last pixel of the view, from its own left, that no toolbar or sidebar lies over."""
    left, right = 0.0, float(region.width)
    for other in area.regions:
        if other.type == "TOOLS" and other.width > 1:
            left = max(left, other.x + other.width - region.x)
        elif other.type == "UI" and other.width > 1:
            right = min(right, other.x - region.x)
    return (left, right) if right > left else (0.0, float(region.width))


def written(length: float, settings: bpy.types.UnitSettings) -> str:
    """A length in the scene's units; a plain number where it has none."""
    if settings.system == "NONE":
        return f"{length:.4g}"
    return bpy.utils.units.to_string(settings.system, "LENGTH", length * settings.scale_length, precision=4)


def _ramp(left: float, foot: float, width: float, height: float) -> None:
    x = left + width * np.linspace(0.0, 1.0, len(RAMP))
    corners = np.array([(place, y, 0.0) for place in x for y in (foot, foot + height)], np.float32)
    batch = overlay_batches.batch("TRI_STRIP", {"pos": corners, "color": np.repeat(RAMP, 2, axis=0)})
    batch.draw(overlay_batches.shader("SMOOTH_COLOR"))


def _text(text: str, x: float, y: float, scale: float, colour: tuple[float, ...], share: float) -> None:
    """A line of text of which ``share`` stands left of x."""
    font = 0
    blf.size(font, 11.0 * scale)
    blf.color(font, *colour)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 0.6)
    blf.position(font, x - share * blf.dimensions(font, text)[0], y, 0.0)
    blf.draw(font, text)
    blf.disable(font, blf.SHADOW)
