# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures in numbers: a table of every frame of one, and one table that compares the methods over all."""

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from figure import Figure, FigureRow, Variant

METHODS = ("Sweep", "Balanced", "Gradient", "Nearest")
REPEATS = 3
"""Frames computed for the time of one, none from memory; the quickest counts."""


@dataclass(frozen=True)
class MethodRow:
    """One method in the last frame of one variant. ``change``: of the volume under the lattice alone, relative to that
    at rest; ``error``: of the corrected volume on the evaluated mesh; ``distance``: root of the sum of squares of how
    far the correction moves the control points, in sizes of the model, its largest extent at rest; ``ran``: the method
    that was used in the end."""

    figure: str
    variant: str
    vertices: int
    change: float
    method: str
    ran: str
    error: float
    distance: float
    milliseconds: float


def write_frames(place: Path, rows: list["FigureRow"]) -> None:
    """A figure's table, floats with all digits that the evaluated mesh gives them."""
    extra = list(rows[0].measures)
    head = ["variant", "frame", "plain volume", "plain change", "corrected volume", "target", "relative error", *extra]
    with open(place, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(head)
        for row in rows:
            volumes = (row.volume, row.target, row.error) if row.promised else ("", "", "")
            writer.writerow([row.variant, row.frame, row.plain, row.plain_change, *volumes, *row.measures.values()])


def method_rows(figure: "Figure") -> list[MethodRow]:
    """Every method that the extension has, for every variant of the figure that is corrected."""
    names = [name for name in METHODS if name in figure.staged.menu("Method")]
    corrected = [variant for variant in figure.variants if variant.promised]
    return [_method_row(figure, variant, name) for variant in corrected for name in names]


def _method_row(figure: "Figure", variant: "Variant", method: str) -> MethodRow:
    import bpy

    staged = figure.staged
    before = staged.value("Method")
    staged.put(Method=method)
    row = next(row for row in figure.rows((figure.last,)) if row.variant == variant.name)
    times = []
    for _ in range(REPEATS):
        bpy.ops.isochor.clear_memory()
        figure.show(figure.variants[0], figure.last)
        figure.show(variant, figure.last)
        report = staged.report
        times.append(report.milliseconds)
    staged.put(Method=before)
    numbers = (row.error, report.result.distance / staged.size, min(times))
    count = len(staged.object.data.vertices)
    return MethodRow(
        figure.name, variant.name, count, row.plain_change, method, report.result.method.capitalize(), *numbers
    )


def write_methods(place: Path, rows: list[MethodRow]) -> None:
    """The table of all figures that were made in this run."""
    with open(place, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(MethodRow)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def read_methods(place: Path) -> list[MethodRow]:
    """What write_methods wrote."""
    with open(place, newline="", encoding="utf-8") as stream:
        return [_parsed(record) for record in csv.DictReader(stream)]


def _parsed(record: dict[str, str]) -> MethodRow:
    numbers = {name: float(record[name]) for name in ("change", "error", "distance", "milliseconds")}
    return MethodRow(**{**record, **numbers, "vertices": int(record["vertices"])})
