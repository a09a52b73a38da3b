# SPDX-License-Identifier: GPL-3.0-or-later
"""What a panel puts on the screen, in a Blender without one: a layout that writes down what it is asked to draw."""

from types import SimpleNamespace
from typing import Any

import bpy


class Layout:
    """Takes what Blender's layout takes, as far as Blender tells, and notes texts, inputs and operators."""

    def __init__(self, lines: list[str] | None = None) -> None:
        self.lines: list[str] = [] if lines is None else lines

    def __getattr__(self, name: str) -> Any:
        known = bpy.types.UILayout.bl_rna.functions[name]
        parameters = {found.identifier for found in known.parameters}

        def call(*arguments: Any, **named: Any) -> "Layout":
            assert set(named) <= parameters, f"{name}: {set(named) - parameters}"
            self.lines += [word for word in (*arguments, named.get("text", "")) if isinstance(word, str) and word]
            if "icon" in named:
                icon = named["icon"]
                assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items, icon
            return Layout(self.lines)

        return call


def drawn(panel: type, **context: Any) -> list[str]:
    """Texts, names of properties and of operators that a panel or menu class draws, in order."""
    layout = Layout()
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
    region, view_layer = SimpleNamespace(width=300), bpy.context.view_layer
    shown = SimpleNamespace(region=region, preferences=preferences, view_layer=view_layer, **context)
    panel.draw(SimpleNamespace(layout=layout), shown)
    return layout.lines
