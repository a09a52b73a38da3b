# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender remembers of an operator's last call and what it forgets: a call that leaves out an object, a frame or a
path never means the one of the call before."""

import bpy
import pytest
from installed_extension import MODULE

OPERATORS = {
    found.bl_idname: found for found in bpy.types.Operator.__subclasses__() if found.__module__.startswith(MODULE)
}
OF_THE_OBJECT = {
    "isochor.apply": {"as_shape_key", "keep_modifier", "single_user"},
    "isochor.bend_from_empty": {"replace"},
    "isochor.fit_lattice": {"resolution"},
    "isochor.squash_from_ground": {"replace"},
    "isochor.squash_from_speed": {"full_speed", "replace"},
    "isochor.twist_from_bone": {"replace"},
}
"""Properties that fit the objects of one call, or take something away from them."""


def call(name, **values):
    """As from a menu: with a step of undo, without which Blender remembers nothing of a call."""
    return getattr(bpy.ops.isochor, name.removeprefix("isochor."))("EXEC_DEFAULT", True, **values)


def properties(name):
    rna = getattr(bpy.ops.isochor, name.removeprefix("isochor.")).get_rna_type()
    return {found.identifier: found for found in rna.properties if found.identifier != "rna_type"}


def plain(value):
    return value if isinstance(value, bool | int | float | str) else tuple(value)


def default(found):
    return tuple(found.default_array) if getattr(found, "is_array", False) else found.default


def other_value(found):
    """One that is not the default."""
    before = default(found)
    if found.type == "ENUM":
        return next(item.identifier for item in found.enum_items if item.identifier != before)
    if found.type == "STRING":
        return "Something else"
    if found.type == "BOOLEAN":
        return not before
    if isinstance(before, tuple):
        return tuple(value + 1 for value in before)
    return before + 1 if before + 1 <= found.hard_max else before / 2


def forgotten(name):
    """What a call without it must not take from the call before."""
    named = {key for key, found in properties(name).items() if found.type == "STRING" or key.startswith("frame")}
    return named | OF_THE_OBJECT.get(name, set()) | ({"step"} & set(properties(name)))


@pytest.fixture
def calls(monkeypatch):
    """What each call of an operator was given, instead of doing anything."""
    seen = []

    def recorder(name):
        def execute(self, _context):
            seen.append({key: plain(getattr(self, key)) for key in properties(name)})
            return {"FINISHED"}

        return execute

    for name, operator in OPERATORS.items():
        monkeypatch.setattr(operator, "execute", recorder(name))
        monkeypatch.setattr(operator, "poll", classmethod(lambda _cls, _context: True), raising=False)
    return seen


@pytest.mark.parametrize("name", OPERATORS)
def test_what_a_call_leaves_out_is_not_that_of_the_call_before(name, calls):
    call(name, **{key: other_value(found) for key, found in properties(name).items()})
    call(name)
    for key in forgotten(name):
        assert calls[0][key] == pytest.approx(other_value(properties(name)[key])), key
        assert calls[1][key] == default(properties(name)[key]), key


def test_blender_would_remember_them(calls):
    call("isochor.add", margin=0.5)
    call("isochor.add")
    assert calls[1]["margin"] == 0.5


def test_the_operators_that_take_objects_frames_and_paths_are_among_them():
    found = {name: forgotten(name) for name in OPERATORS}
    assert {"directory", "filepath", "frame_start", "frame_end"} <= found["isochor.bake"]
    assert {"armature", "bone"} <= found["isochor.twist_from_bone"]
    assert "empty" in found["isochor.bend_from_empty"]
    assert "ground" in found["isochor.squash_from_ground"]
    assert {"frame_start", "ground_object", "pinned"} <= found["isochor.simulate"]
    assert {"frame_start", "frame_end", "step"} <= found["isochor.measure_volume"]
