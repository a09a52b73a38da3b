# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the add-on import downwards only: core knows no Blender, tool no interface."""

import ast
from pathlib import Path

import pytest
from workspace import ROOT

ADDON = ROOT / "addon" / "isochor"
BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "blf", "bpy_extras", "addon_utils"}


def imports(place: Path) -> set[str]:
    """First names of all imports, those of this package by its layer."""
    found = set()
    for node in ast.walk(ast.parse(place.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name.split(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = [node.module] if node.module else [name.name for name in node.names]
            own = place.parent.name if node.level == 1 else ""
            found |= {own} if own else {name.split(".")[0] for name in names}
    return found


def files(layer: str) -> list[Path]:
    return sorted((ADDON / layer).glob("*.py"))


@pytest.mark.parametrize("place", files("core"), ids=lambda place: place.stem)
def test_core_knows_neither_blender_nor_the_layers_above(place):
    assert not imports(place) & (BLENDER | {"tool", "ui"})


@pytest.mark.parametrize("place", files("tool"), ids=lambda place: place.stem)
def test_tool_knows_no_interface(place):
    assert "ui" not in imports(place)


def test_the_check_sees_imports_of_blender_and_of_other_layers():
    assert "bpy" in imports(ADDON / "tool" / "update.py")
    assert {"bpy", "core", "tool"} <= imports(ADDON / "ui" / "baking.py")
