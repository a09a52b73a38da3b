# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers on a modifier's inputs: simple expressions, which Blender evaluates with Python auto-run off."""

import re
from dataclasses import dataclass

import bpy

from . import animated, animation_paths, sockets

OWN = frozenset(
    "height ground speed roll ex ey ez ox oy oz ax ay az bx by bz cx cy cz".split(),
)
"""Names of the variables that the add-on's drivers use; a driver with any other is somebody else's."""


@dataclass(frozen=True)
class Variable:
    """One number that an expression reads: a property of ``target`` by its path, or, where ``transform`` names one of
    Blender's transform channels, that channel of the object or of its ``bone``."""

    name: str
    target: bpy.types.ID
    path: str = ""
    transform: str = ""
    bone: str = ""
    space: str = "WORLD_SPACE"
    rotation: str = "AUTO"


def data_path(modifier: bpy.types.NodesModifier, name: str) -> str:
    """Path of an input from its object, for keys and drivers."""
    path, start = sockets.data_path(modifier, name), animation_paths.of_modifier(modifier)
    return f"{start}{path}" if path.startswith("[") else f"{start}.{path}"


def of(obj: bpy.types.Object, path: str) -> bpy.types.FCurve | None:
    """The driver at this path of the object."""
    data = obj.animation_data
    return None if data is None else data.drivers.find(path)


def is_own(curve: bpy.types.FCurve) -> bool:
    """Whether the add-on put this driver, so that it may change it."""
    names = {variable.name for variable in curve.driver.variables}
    return bool(names) and names <= OWN


def keys_of(obj: bpy.types.Object, path: str) -> bpy.types.FCurve | None:
    """The curve of keys at this path in the object's action."""
    data = obj.animation_data
    found = () if data is None else animated.curves(data.action, data.action_slot)
    return next((curve for curve in found if curve.data_path == path), None)


def put(
    obj: bpy.types.Object,
    modifier: bpy.types.NodesModifier,
    name: str,
    expression: str,
    variables: list[Variable],
    shares: bool = False,
    at_most: str = "",
) -> bpy.types.FCurve:
    """Drives an input. What drove it before goes, but where it ``shares`` the input with the add-on's own drivers that
    read other variables: then the least of them all counts. ``at_most``, a number, limits it where it is alone."""
    path = data_path(modifier, name)
    before = of(obj, path)
    shared = before.driver.expression if shares and before is not None and is_own(before) else ""
    kept = [part for part in least_of(shared) if is_others(part, variables)]
    curve = before or obj.driver_add(path)
    driver = curve.driver
    driver.type = "SCRIPTED"
    used = {word for part in kept for word in words(part)}
    for variable in list(driver.variables):
        if variable.name not in used:
            driver.variables.remove(variable)
    for variable in variables:
        _add_variable(driver, variable)
    parts = [*(kept or filter(None, [at_most])), expression]
    driver.expression = parts[0] if len(parts) == 1 else f"min({', '.join(parts)})"
    obj.update_tag()
    return curve


def is_others(expression: str, variables: list[Variable]) -> bool:
    """Whether an expression reads something, and none of these variables."""
    read = words(expression) & OWN
    return bool(read) and not read & {variable.name for variable in variables}


def least_of(expression: str) -> list[str]:
    """What stands between the commas of ``min(…)``; the expression itself where it is no such call."""
    if not (expression.startswith("min(") and expression.endswith(")")):
        return [expression]
    parts, depth = [""], 0
    for letter in expression[len("min(") : -1]:
        depth += (letter == "(") - (letter == ")")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def words(expression: str) -> set[str]:
    """Names in an expression."""
    return set(re.findall(r"[A-Za-z_]\w*", expression))


def number(value: float) -> str:
    """A number as an expression holds it: six digits, which keeps the longest expressions short enough."""
    return f"{value:.6g}"


def signed(value: float) -> str:
    """The same to be added: "+ 2" or "- 2"."""
    return f"{'-' if value < 0.0 else '+'} {number(abs(value))}"


def _add_variable(driver: bpy.types.Driver, given: Variable) -> None:
    variable = driver.variables.new()
    variable.name = given.name
    variable.type = "TRANSFORMS" if given.transform else "SINGLE_PROP"
    target = variable.targets[0]
    if not given.transform:
        target.id_type = given.target.id_type
        target.id, target.data_path = given.target, given.path
        return
    target.id, target.bone_target = given.target, given.bone
    target.transform_type, target.transform_space = given.transform, given.space
    target.rotation_mode = given.rotation
