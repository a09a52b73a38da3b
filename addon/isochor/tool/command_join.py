# SPDX-License-Identifier: GPL-3.0-or-later
"""The command join: puts parts together, and saves a file that plays them."""

import argparse
from dataclasses import replace
from pathlib import Path

import bpy

from ..core import joining, part_file, point_cache
from ..core.atomic_file import atomic
from ..core.frame_range import parse
from ..core.part_file import Whole
from ..core.problem import Problem
from . import bake_file, cache_places, command_scene, frames


def run(options: argparse.Namespace) -> None:
    """Joins as the options say. Raises Problem."""
    first, last = parse(options.frames, "--frames")
    file = Path(options.file)
    command_scene.open_file(file)
    if options.save is not None and Path(options.save).resolve() == file.resolve():
        raise Problem("--save names the file itself: give another, which is made.")
    blend = command_scene.fingerprint(file)
    like = Whole("", blend, first, last, options.samples)
    asked = options.object or joining.asked_for(Path(options.output) / part_file.FOLDER, like)
    chosen = command_scene.chosen_targets(asked)
    wholes = {target.obj.name: replace(like, object=target.obj.name) for target in chosen}
    paths = join(chosen, wholes, Path(options.output), options.format)
    if options.save is not None:
        _save(chosen, paths, bake_file.Plan(options.format, first, last, options.samples), Path(options.save))


def join(chosen: list[frames.Target], wholes: dict[str, Whole], folder: Path, kind: point_cache.Format) -> list[Path]:
    """Writes the file of each object from its parts in the folder's folder of parts. Raises Problem, before anything is
    written, where one lacks a frame."""
    paths = cache_places.in_folder([target.obj for target in chosen], folder, kind)
    with bake_file.plain_words():
        place = folder / part_file.FOLDER
        found = {name: joining.find(place, whole, range(whole.count)) for name, whole in wholes.items()}
        for name, whole in wholes.items():
            joining.require_complete(found[name], whole)
        for path, (name, whole) in zip(paths, wholes.items(), strict=True):
            _write(path, kind, found[name], whole)
    command_scene.tell_done()
    return paths


def _write(path: Path, kind: point_cache.Format, found: joining.Found, whole: Whole) -> None:
    layout = bake_file.layout(found.vertices(), bake_file.Plan(kind, whole.first, whole.last, whole.samples))
    with atomic(path) as file:
        file.write(point_cache.header(kind, layout))
        for positions in joining.joined(found, whole):
            file.write(point_cache.sample(kind, positions))


def _save(chosen: list[frames.Target], paths: list[Path], plan: bake_file.Plan, place: Path) -> None:
    """Saves a copy that plays the files, by paths relative to where it lies."""
    plan.require_playable()
    for target, path in zip(chosen, paths, strict=True):
        for text in bake_file.play(target, cache_places.relative(path.absolute()), plan):
            print(f"Warning: {text}", flush=True)
    place = place.absolute()
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(place), copy=True, relative_remap=True, check_existing=False)
    except RuntimeError as error:
        raise Problem(f"“{place}” cannot be saved: {str(error).strip()}") from error
