# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences with names and numbers in them that can still be translated once they are made."""

from collections.abc import Callable
from typing import Any


class Sentence(str):
    """English text, made from a template with {places} and what stands in them; both are kept.

    Wherever text is expected this is the English one; whoever shows it asks for ``translated``.
    """

    template: str
    values: dict[str, Any]

    def __new__(cls, template: str, **values: Any) -> "Sentence":
        made = super().__new__(cls, template.format(**values))
        made.template, made.values = template, values
        return made

    def __str__(self) -> str:
        return self

    def translated(self, translate: Callable[[str], str]) -> str:
        """The sentence from its template in another language."""
        return translate(self.template).format(**self.values)
