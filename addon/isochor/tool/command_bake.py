# SPDX-License-Identifier: GPL-3.0-or-later
"""The command bake: writes point caches, or parts of them that any number of machines make at the same time."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..core import joining, part_file
from ..core.atomic_file import atomic
from ..core.frame_range import parse
from ..core.part_file import Whole
from ..core.problem import Problem
from ..core.tally import Tally
from . import bake_file, cache_places, command_join, command_scene, frames, recording

PIECE = 25
"""Frames to a part where a bake in one go is to resume: as many are lost at most when it is ended."""


def run(options: argparse.Namespace) -> None:
    """Bakes as the options say. Raises Problem."""
    first, last = parse(options.frames, "--frames")
    file = Path(options.file)
    command_scene.open_file(file)
    chosen = command_scene.chosen_targets(options.object)
    if options.part_of is None and not options.resume:
        _bake_whole(options, chosen, bake_file.Plan(options.format, first, last, options.samples))
        return
    begin, end = (first, last) if options.part_of is None else parse(options.part_of, "--part-of")
    if first < begin or last > end:
        raise Problem(f"--frames {first}-{last} is no part of {begin}-{end}: choose frames within --part-of.")
    blend = command_scene.fingerprint(file)
    wholes = {target.obj.name: Whole(target.obj.name, blend, begin, end, options.samples) for target in chosen}
    if options.part_of is None:
        _bake_pieces(options, chosen, wholes)
        command_join.join(chosen, wholes, Path(options.output), options.format)
    else:
        _bake_part(options, chosen, wholes, (first, last))


def _bake_whole(options: argparse.Namespace, chosen: list[frames.Target], plan: bake_file.Plan) -> None:
    paths = cache_places.in_folder([target.obj for target in chosen], Path(options.output), plan.kind)
    tally = Tally()
    for step in bake_file.record_files(bpy.context, chosen, paths, plan, tally, strict=not options.allow_problems):
        command_scene.tell(step, _words(chosen))


def _bake_pieces(options: argparse.Namespace, chosen: list[frames.Target], wholes: dict[str, Whole]) -> None:
    """The parts that are missing, in pieces, the earliest frames first."""
    whole = next(iter(wholes.values()))
    for start in range(whole.first, whole.last + 1, PIECE):
        _bake_part(options, chosen, wholes, (start, min(start + PIECE - 1, whole.last)))


def _bake_part(
    options: argparse.Namespace, chosen: list[frames.Target], wholes: dict[str, Whole], chunk: tuple[int, int]
) -> None:
    folder = Path(options.output) / part_file.FOLDER
    if options.resume:
        chosen = [target for target in chosen if not _is_there(folder, wholes[target.obj.name], chunk)]
    if not chosen:
        command_scene.tell_done()
        return
    whole = wholes[chosen[0].obj.name]
    every = frames.moments(whole.first, whole.last, whole.samples)
    when = [every[index] for index in whole.indices(*chunk)]
    names = {
        target.obj.name: name
        for target, name in zip(chosen, cache_places.file_names([target.obj for target in chosen]), strict=True)
    }

    @contextmanager
    def opening(target: frames.Target, vertices: int) -> Iterator[recording.Sink]:
        mine = wholes[target.obj.name]
        with atomic(folder / part_file.file_name(names[target.obj.name], mine, *chunk)) as file:
            writer = part_file.Writer(file, part_file.Head(mine, *chunk, vertices, tuple(options.object)))
            yield writer.sample
            writer.finish()

    strict = not options.allow_problems
    with bake_file.plain_words():
        for step in recording.record(bpy.context, chosen, when, opening, Tally(), strict, every[0]):
            command_scene.tell(step, _words(chosen))


def _is_there(folder: Path, whole: Whole, chunk: tuple[int, int]) -> bool:
    """Whether sound parts hold every sample of the chunk."""
    wanted = whole.indices(*chunk)
    return set(wanted) <= joining.find(folder, whole, wanted).covered()


def _words(chosen: list[frames.Target]) -> str:
    return ", ".join(target.obj.name for target in chosen)
