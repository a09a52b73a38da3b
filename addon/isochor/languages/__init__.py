# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's texts in other languages, one module each: a dictionary TEXTS from English to that language.

Places in {braces} stay as they are. A class's docstring, which Blender shows as its tooltip, stands there in one line.
``addon/tools/list_untranslated.py`` tells what a language lacks.
"""

import bpy

from ..tool.device import PACKAGE
from . import german

LANGUAGES = {"de_DE": german.TEXTS}
CONTEXTS = (bpy.app.translations.contexts.default, bpy.app.translations.contexts.operator_default)
"""Blender asks for the label of an operator in a context of its own."""
KINDS = ("Operator", "Panel", "Menu", "AddonPreferences", "PropertyGroup")


def catalogues() -> dict[str, dict[tuple[str, str], str]]:
    """What Blender's translations take: by language, by context and English text."""
    return {language: _with_docstrings(texts) for language, texts in LANGUAGES.items()}


def _with_docstrings(texts: dict[str, str]) -> dict[tuple[str, str], str]:
    """The texts in every context, those of docstrings also with the breaks of lines that they have in the code."""
    found = texts | {doc: texts[line] for doc in _docstrings() if (line := " ".join(doc.split())) in texts}
    return {(context, english): text for english, text in found.items() for context in CONTEXTS}


def _docstrings() -> list[str]:
    kinds = [getattr(bpy.types, name) for name in KINDS]
    classes = [found for kind in kinds for found in kind.__subclasses__() if found.__module__.startswith(PACKAGE)]
    return [found.__doc__ for found in classes if found.__doc__]


def register() -> None:
    """Adds the languages; after every class, for their docstrings."""
    bpy.app.translations.register(PACKAGE, catalogues())


def unregister() -> None:
    """Takes them away."""
    bpy.app.translations.unregister(PACKAGE)
