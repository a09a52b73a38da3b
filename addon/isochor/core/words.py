# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences with names and numbers in them that can still be translated once they are made."""

from collections.abc import Callable, Iterable
from typing import Any


class Sentence(str):
    """English text, made from a template with {places} and what stands in them; both are kept. A sentence in a place
    is translated with the one around it, other text (names) stays. A template without values may hold any braces.

    Wherever text is expected this is the English one; whoever shows it asks for ``translated``.
    """

    template: str
    values: dict[str, Any]

    def __new__(cls, template: str, **values: Any) -> "Sentence":
        made = super().__new__(cls, _filled(template, values))
        made.template, made.values = template, values
        return made

    def __str__(self) -> str:
        return self

    def translated(self, translate: Callable[[str], str]) -> str:
        """The sentence from its template in another language."""
        values = {
            name: value.translated(translate) if isinstance(value, Sentence) else value
            for name, value in self.values.items()
        }
        return _filled(translate(self.template), values)


def sentence(text: str) -> Sentence:
    """Plain text, which is translated whole, as a sentence; a sentence as it is."""
    return text if isinstance(text, Sentence) else Sentence(text)


def named(name: str, text: str) -> Sentence:
    """The text, and before it what it is about."""
    return Sentence("{name}: {text}", name=name, text=sentence(text))


def together(texts: Iterable[str]) -> Sentence:
    """Several texts one after the other, each translated by itself."""
    places = {f"text_{number}": sentence(text) for number, text in enumerate(texts)}
    return Sentence(" ".join(f"{{{place}}}" for place in places), **places)


def listed(names: Iterable[str]) -> str:
    """Names as they stand in a sentence, each in quotes: “A”, “B”."""
    return ", ".join(f"“{name}”" for name in names)


def _filled(template: str, values: dict[str, Any]) -> str:
    return template.format(**values) if values else template
