# SPDX-License-Identifier: GPL-3.0-or-later
"""The command report: the volume of the objects frame by frame, as a table and a curve."""

import argparse
import csv
import io
import sys
from contextlib import closing
from pathlib import Path

import bpy
import numpy as np

from ..core.atomic_file import atomic
from ..core.bodies import volumes as body_volumes
from ..core.curve_image import Picture, draw_volume_curve, percent_of, png_bytes
from ..core.frame_range import parse
from ..core.problem import Problem
from ..core.tally import Tally
from . import bake_file, command_scene, frames, state

COLUMNS = ("frame", "object", "target", "before", "after", "relative_error")
Row = tuple[str, str, float | None, float | None, float | None, float | None]
"""As the columns say; volumes in cubic units of the object's own space, None where the mesh encloses none."""


def run(options: argparse.Namespace) -> None:
    """Reports as the options say. Raises Problem, after writing, where the volume could not be kept."""
    when = frames.moments(*parse(options.frames, "--frames"))
    command_scene.open_file(Path(options.file))
    chosen = command_scene.chosen_targets(options.object)
    tally, rows = Tally(), []
    with closing(frames.walk(bpy.context, chosen, when)) as steps:
        for done, moment in enumerate(steps, 1):
            for target in chosen:
                rows.append(measure(target, moment))
                tally.add(target.obj.name, moment.words, target.problems())
            if options.output:
                command_scene.tell(frames.Step(done, len(when), moment), "volume")
    with bake_file.plain_words():
        _write(rows, options.output)
    if tally.count and not options.allow_problems:
        raise Problem(tally.words)


def measure(target: frames.Target, moment: frames.Moment) -> Row:
    """One row, of what was evaluated for this moment: the volume after is measured in float64 on the vertices that
    leave the modifier."""
    memory = state.recall(target.obj, target.last)
    triangles = None if memory is None else memory.faces.triangles
    volumes = None if memory is None else memory.report.volumes
    bodies = None if memory is None or memory.asked is None else memory.asked.bodies
    left = frames.leaving(target, bpy.context)
    after = None if triangles is None else float(body_volumes(left, triangles, bodies).sum())
    if volumes is None or after is None:
        return moment.words, target.obj.name, None, None, after, None
    error = (after - volumes.target) / volumes.target if volumes.target else None
    return moment.words, target.obj.name, volumes.target, volumes.before, after, error


def table(rows: list[Row]) -> str:
    """The rows as CSV, with every digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([["" if value is None else value for value in row] for row in rows])
    return text.getvalue()


def picture(rows: list[Row]) -> Picture:
    """The curves of the objects, one below the other."""
    found = []
    for name in dict.fromkeys(row[1] for row in rows):
        mine = [row for row in rows if row[1] == name]
        when = [float(row[0]) for row in mine]
        target, before, after = (
            np.array([np.nan if row[place] is None else row[place] for row in mine], np.float64) for place in (2, 3, 4)
        )
        found.append(draw_volume_curve(when, percent_of(before, target), percent_of(after, target), title=name))
    return np.concatenate(found)


def _write(rows: list[Row], folder: str | None) -> None:
    if folder is None:
        sys.stdout.write(table(rows))
        sys.stdout.flush()
        return
    with atomic(Path(folder) / "volume.csv") as file:
        file.write(table(rows).encode())
    with atomic(Path(folder) / "volume.png") as file:
        file.write(png_bytes(picture(rows)))
