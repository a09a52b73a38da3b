# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the templates under test are, and how to read the commands that they make."""

from pathlib import Path

FARM = Path(__file__).resolve().parents[2] / "addon" / "farm"


def options(words: list[str]) -> dict[str, list[str]]:
    """The options of a command as given, --name=value, --name value or --flag: each with all its values."""
    found: dict[str, list[str]] = {}
    rest = list(words)
    while rest:
        name, equals, value = rest.pop(0).partition("=")
        assert name.startswith("--"), f"{name} is no option"
        if not equals and rest and not rest[0].startswith("--"):
            value = rest.pop(0)
        found.setdefault(name, []).append(value)
    return found
