# SPDX-License-Identifier: GPL-3.0-or-later
"""Text made at run time, in the user's language. What Blender is handed whole (labels, tooltips, reports that hold no
names) it looks up by itself."""

from collections.abc import Callable

from bpy.app import translations

from ..core.words import Sentence


def shown(text: str) -> str:
    """For panels."""
    return _in(text, translations.pgettext_iface)


def reported(text: str) -> str:
    """For reports of operators."""
    return _in(text, translations.pgettext_rpt)


def _in(text: str, translate: Callable[[str], str]) -> str:
    return text.translated(translate) if isinstance(text, Sentence) else translate(text)
