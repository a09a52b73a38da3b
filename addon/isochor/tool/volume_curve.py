# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the volume of Volume Lattices over frames as the viewport shows them, and keeps what was found."""

from collections.abc import Generator, Sequence

import bpy

from ..core import problem
from ..core.bodies import volumes as body_volumes
from ..core.targets import target_volume
from ..core.volume_curve import UNKNOWN, Sample, VolumeCurve
from ..core.words import Sentence, together
from . import results, stack, state
from .frames import frame_kept

KEY = "isochor_volume_curve"
"""Custom property of a modifier's viewport result object: what ``VolumeCurve.mapping`` gives, by name."""

NONE_ENCLOSED = "it encloses none."

Pair = tuple[bpy.types.Object, bpy.types.NodesModifier]


def read(modifier: bpy.types.NodesModifier) -> VolumeCurve | None:
    """The curve that was measured last of a modifier, or None."""
    result = results.of(modifier, "VIEWPORT")
    kept = None if result is None else result.get(KEY)
    return None if kept is None else VolumeCurve.from_mapping(kept)


def keep(modifier: bpy.types.NodesModifier, curve: VolumeCurve) -> None:
    """Keeps the curve in the file, in place of the one before."""
    result = results.of(modifier, "VIEWPORT")
    if result is not None:
        result[KEY] = curve.mapping()


def require_measurable(pairs: Sequence[Pair]) -> None:
    """Raises Problem, naming the object, where one of them cannot be measured."""
    for obj, modifier in pairs:
        if not obj.is_editable:
            raise problem.Problem(problem.linked(obj.name))
        if obj.mode == "EDIT":
            raise problem.Problem(problem.in_edit_mode([obj.name]))
        if not stack.is_on(modifier, "VIEWPORT"):
            raise problem.Problem(
                Sentence(
                    "“{modifier}” is switched off on “{name}”: switch it on in the viewport first.",
                    modifier=modifier.name,
                    name=obj.name,
                )
            )


def measure(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, pairs: Sequence[Pair], frames: Sequence[int]
) -> Generator[int, None, list[VolumeCurve]]:
    """Shows one frame after the other and yields how many are done; returns a curve for each pair, kept nowhere yet.
    The scene is shown as before when the generator ends or is closed. Raises Problem where an object is not evaluated
    in this view layer, or no frame of it can be measured."""
    samples: list[list[Sample]] = [[] for _pair in pairs]
    with frame_kept(scene):
        for done, frame in enumerate(frames, 1):
            scene.frame_set(frame)
            for (obj, modifier), row in zip(pairs, samples, strict=True):
                _require_evaluated(obj, view_layer)
                row.append(Sample(frame, *volumes(obj, modifier)))
            yield done
        curves = [VolumeCurve.of(row) for row in samples]
        for (obj, modifier), curve in zip(pairs, curves, strict=True):
            _require_known(obj, modifier, curve)
    return curves


def volumes(obj: bpy.types.Object, modifier: bpy.types.NodesModifier) -> tuple[float, float, float]:
    """Target, before and after of what the viewport evaluated last, each measured in float64 on the vertices that leave
    the modifier, or would without a correction. They are known too where Preserve is 0 or the target cannot be reached;
    NaN where no volume is enclosed."""
    memory = state.recall(obj, modifier)
    if memory is None or memory.written is None:
        return UNKNOWN
    report, left, triangles = memory.report, memory.written.vertices, memory.faces.triangles
    binding = report.embedded
    if left is None or triangles is None or binding is None or memory.asked is None:
        return UNKNOWN
    target = target_volume(binding, memory.asked)
    if target is None:
        return UNKNOWN
    before, bodies = binding.deform(memory.asked.control), memory.asked.bodies
    after = body_volumes(left, triangles, bodies).sum()
    return target, float(body_volumes(before, triangles, bodies).sum()), float(after)


def _require_evaluated(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> None:
    if view_layer.depsgraph is None or not obj.evaluated_get(view_layer.depsgraph).is_evaluated:
        raise problem.Problem(problem.not_shown(obj.name))


def _require_known(obj: bpy.types.Object, modifier: bpy.types.NodesModifier, curve: VolumeCurve) -> None:
    if not curve.is_known:
        memory = state.recall(obj, modifier)
        told = memory.report.problems if memory is not None else ()
        raise problem.Problem(
            Sentence(
                "“{name}” has no volume to measure in any of these frames: {reason}",
                name=obj.name,
                reason=together(told or [NONE_ENCLOSED]),
            )
        )
