# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume curves as pictures inside Blender: a preview for the sidebar, and an image of the file."""

from dataclasses import replace

import bpy
import numpy as np
from bpy.utils import previews

from ..core.curve_image import DARK, LIGHT, Look, Picture, Words, draw_volume_curve
from ..core.tiny_font import LETTERS
from ..core.volume_curve import VolumeCurve
from . import words

IMAGE_OF = "isochor_volume_of"
"""Custom property of an image: the deformed object that its curve is of."""
IMAGE_SIZE = (1600, 800)

_previews: list[previews.ImagePreviewCollection] = []
_drawn: dict[str, tuple[bytes, int, Look, int]] = {}
"""What each preview shows."""


def preview(name: str, curve: VolumeCurve, side: int, look: Look, scale: int) -> int:
    """Icon with the curve, a square of so many pixels, letters enlarged by ``scale``; drawn anew only where something
    has changed. ``name`` tells one preview from another."""
    wanted = (curve.signature, side, look, scale)
    collection = _previews[0]
    icon = collection.get(name) or collection.new(name)
    if _drawn.get(name) != wanted:
        size = side, side
        picture = draw_volume_curve(curve.frames, curve.before_percent, curve.after_percent, size, look, scale=scale)
        icon.image_size = size
        icon.image_pixels_float.foreach_set(pixels(picture))
        _drawn[name] = wanted
    return int(icon.icon_id)


def look_of_theme(context: bpy.types.Context) -> Look:
    """Light on dark where the theme's text is light; in the user's language."""
    return in_words(DARK if sum(context.preferences.themes[0].view_3d.space.text) > 1.5 else LIGHT)


def in_words(look: Look) -> Look:
    """The look with words in the user's language, or in English where the picture's font lacks letters of that."""
    said = (
        words.shown("lattice alone"),
        words.shown("corrected"),
        words.shown("% of target volume"),
        words.shown("frame"),
    )
    return replace(look, words=Words(*said)) if LETTERS.keys() >= set("".join(said)) else look


def image(obj: bpy.types.Object, curve: VolumeCurve) -> bpy.types.Image:
    """The file's image of an object's curve, made where there is none; it is packed and has a fake user,
    so that it is saved."""
    picture = draw_volume_curve(
        curve.frames, curve.before_percent, curve.after_percent, IMAGE_SIZE, in_words(LIGHT), title=obj.name
    )
    found = next((image for image in bpy.data.images if image.get(IMAGE_OF) == obj), None)
    if found is None or not found.is_editable:
        found = bpy.data.images.new(f"{obj.name} Volume", *IMAGE_SIZE)
        found[IMAGE_OF] = obj
        found.use_fake_user = True
    if tuple(found.size) != IMAGE_SIZE:
        found.scale(*IMAGE_SIZE)
    found.pixels.foreach_set(pixels(picture))
    found.update()
    found.pack()
    return found


def pixels(picture: Picture) -> np.ndarray:
    """Flat, bottom row first, in [0, 1], as Blender takes them."""
    return (picture[::-1].astype(np.float32) / np.float32(255.0)).reshape(-1)


def register() -> None:
    """Makes room for previews."""
    _previews.append(previews.new())


def unregister() -> None:
    """Takes them away."""
    previews.remove(_previews.pop())
    _drawn.clear()
