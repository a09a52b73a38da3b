# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's types of objects in plain words."""

from collections.abc import Callable

from .words import Sentence

KINDS = {
    "ARMATURE": "Armature",
    "CAMERA": "Camera",
    "CURVE": "Curve",
    "CURVES": "Hair Curves",
    "EMPTY": "Empty",
    "FONT": "Text",
    "GPENCIL": "Grease Pencil",
    "GREASEPENCIL": "Grease Pencil",
    "LATTICE": "Lattice",
    "LIGHT": "Light",
    "LIGHT_PROBE": "Light Probe",
    "MESH": "Mesh",
    "META": "Metaball",
    "POINTCLOUD": "Point Cloud",
    "SPEAKER": "Speaker",
    "SURFACE": "Surface",
    "VOLUME": "Volume",
}
"""The labels that Blender has for them, and translates by itself."""


class Kind(Sentence):
    """A type of objects, such as MESH, as a word within a sentence."""

    def __new__(cls, kind: str) -> "Kind":
        label = KINDS.get(kind, kind.title().replace("_", " "))
        made = str.__new__(cls, label.lower())
        made.template, made.values = label, {}
        return made

    def translated(self, translate: Callable[[str], str]) -> str:
        """As Blender labels it in the language; where it does not, the English word."""
        found = translate(self.template)
        return self if found == self.template else found
