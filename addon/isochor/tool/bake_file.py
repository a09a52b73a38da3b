# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes to point caches, PC2 or MDD, which a Mesh Cache modifier then plays in the place of ours."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..core import point_cache, problem
from ..core.atomic_file import atomic
from ..core.tally import Tally
from ..core.words import Sentence, sentence
from . import baked, cache_places, frames, recording, stack, state

NAME = "Volume Lattice Cache"
FASTEST = 100
"""Samples to a frame that a Mesh Cache modifier can tell apart."""


@dataclass(frozen=True)
class Plan:
    """Which frames to bake, how finely, in which format."""

    kind: point_cache.Format
    frame_start: int
    frame_end: int
    samples: int = 1

    @property
    def moments(self) -> list[frames.Moment]:
        """Every sample of the file."""
        return frames.moments(self.frame_start, self.frame_end, self.samples)

    @property
    def scale(self) -> float:
        """Samples to a frame of the animation, which the scene's time stretching makes other than one of the scene."""
        render = bpy.context.scene.render
        return self.samples * render.frame_map_new / render.frame_map_old

    def require_playable(self) -> None:
        """Raises Problem where a Mesh Cache modifier cannot play so many samples to a frame."""
        if self.scale > FASTEST:
            raise problem.Problem(
                Sentence(
                    "{samples} samples to a frame and the scene's Time Stretching are more than a Mesh Cache modifier"
                    " can play: take fewer samples.",
                    samples=self.samples,
                )
            )


def bake(
    context: bpy.types.Context, chosen: list[frames.Target], paths: list[Path], plan: Plan
) -> Generator[frames.Step, None, list[str]]:
    """Writes the file of each object and has it play; returns warnings in plain words. Files and objects are as they
    were where the iterator is closed before its end, or raises Problem."""
    tally = Tally()
    plan.require_playable()
    yield from record_files(context, chosen, paths, plan, tally)
    warnings = list(tally.lines)
    for target, path in zip(chosen, paths, strict=True):
        warnings += play(target, cache_places.relative(path), plan)
    return warnings


def record_files(
    context: bpy.types.Context,
    chosen: list[frames.Target],
    paths: list[Path],
    plan: Plan,
    tally: Tally,
    strict: bool = False,
) -> Iterator[frames.Step]:
    """Writes the file of each object, and nothing else; not even that where ``strict`` and there is a problem."""
    place = dict(zip([target.obj.name for target in chosen], paths, strict=True))

    @contextmanager
    def opening(target: frames.Target, vertices: int) -> Iterator[recording.Sink]:
        with atomic(place[target.obj.name]) as file:
            file.write(point_cache.header(plan.kind, layout(vertices, plan)))
            yield lambda positions: file.write(point_cache.sample(plan.kind, positions))

    with plain_words():
        yield from recording.record(context, chosen, plan.moments, opening, tally, strict)


def layout(vertices: int, plan: Plan) -> point_cache.Layout:
    """What the file's header says."""
    render = bpy.context.scene.render
    seconds = render.fps / render.fps_base
    return point_cache.Layout(vertices, len(plan.moments), plan.frame_start, plan.samples, seconds)


@contextmanager
def plain_words() -> Iterator[None]:
    """Turns what the system says of files into a Problem."""
    try:
        yield
    except OSError as error:
        name, reason = error.filename or sentence("The file"), error.strerror or str(error)
        raise problem.Problem(
            Sentence(
                "“{name}” cannot be written: {reason}. Correct that, or give another folder.", name=name, reason=reason
            )
        ) from error


def play(target: frames.Target, path: str, plan: Plan) -> list[str]:
    """Puts a Mesh Cache modifier right behind ours, or changes the one that a bake before made; ours are switched off
    and kept. Where the viewport shows another mesh than renders, which the file does not fit, renders alone play it,
    and the warning that is returned says so."""
    obj = target.obj
    cache = baked.stand_in(obj)
    if cache is None or cache.type != "MESH_CACHE":
        baked.drop(obj)
        cache = obj.modifiers.new(NAME, "MESH_CACHE")
    _fill(cache, path, plan)
    stack.move_behind(cache, target.last)
    differing = _differing(target)
    baked.switch_over(obj, cache, ("render",) if differing else ("viewport", "render"))
    state.forget([obj])
    return [_only_renders(obj.name, differing)] if differing else []


def _fill(cache: bpy.types.MeshCacheModifier, path: str, plan: Plan) -> None:
    cache.cache_format = plan.kind
    cache.filepath = path
    cache.interpolation = "LINEAR"
    cache.deform_mode, cache.factor = "OVERWRITE", 1.0
    cache.play_mode, cache.time_mode = "SCENE", "FRAME"
    # The modifier looks up the sample number scale · time - start, where time is the frame with the scene's remapping.
    cache.frame_scale, cache.frame_start = plan.scale, plan.frame_start * plan.samples
    cache.forward_axis, cache.up_axis = "POS_Y", "POS_Z"
    cache.flip_axis = (False, False, False)


def _differing(target: frames.Target) -> list[str]:
    """Names of the modifiers before ours that show another mesh in the viewport than in renders."""
    found = stack.differing_before(target.obj, target.last)
    return list(dict.fromkeys(other.name for other, _viewport, _render in found if not stack.is_ours(other)))


def _only_renders(name: str, differing: list[str]) -> str:
    return Sentence(
        "{name}: {modifiers} makes another mesh in the viewport than in renders, so renders play the cache and the"
        " viewport does not: give it the same settings for both, and bake again.",
        name=name,
        modifiers=", ".join(differing),
    )
