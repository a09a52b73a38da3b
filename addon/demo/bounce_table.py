# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounce in numbers: one row a frame, written to and read from volume.csv, and judged (standard library only)."""

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surface_measures import SurfaceMeasure

VOLUME_TOLERANCE = 1e-6
LOSS_TOLERANCE = 0.02
ROUNDNESS_TOLERANCE = 0.01


@dataclass(frozen=True)
class BounceRow:
    """One frame: volumes and extents in scene units; changes relative to the ball at rest; marked_loss or None."""

    frame: int
    marked_loss: float | None
    rest_volume: float
    plain_volume: float
    plain_change: float
    isochor_volume: float
    isochor_error: float
    plain_x: float
    plain_y: float
    plain_z: float
    isochor_x: float
    isochor_y: float
    isochor_z: float


def make_row(
    frame: int, marked_loss: float | None, rest_volume: float, plain: "SurfaceMeasure", isochor: "SurfaceMeasure"
) -> BounceRow:
    """Row of a frame from the SurfaceMeasures of the ball under the plain lattice and under Isochor."""
    return BounceRow(
        frame,
        marked_loss,
        rest_volume,
        plain.volume,
        plain.volume / rest_volume - 1,
        isochor.volume,
        isochor.volume / rest_volume - 1,
        *plain.extents,
        *isochor.extents,
    )


def write_table(path: Path, rows: list[BounceRow]) -> None:
    """Writes `rows` as CSV, floats with all their digits."""
    with open(path, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(BounceRow)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def read_table(path: Path) -> list[BounceRow]:
    """Rows that `write_table` wrote."""
    with open(path, newline="", encoding="utf-8") as stream:
        return [_parse(record) for record in csv.DictReader(stream)]


def _parse(record: dict[str, str]) -> BounceRow:
    numbers: dict[str, Any] = {name: float(text) if text else None for name, text in record.items()}
    return BounceRow(**{**numbers, "frame": int(record["frame"])})


def complaints(rows: list[BounceRow]) -> list[str]:
    """What is wrong with the bounce, in words; empty if it is right."""
    found = []
    for row in rows:
        if not abs(row.isochor_error) <= VOLUME_TOLERANCE:
            found.append(
                f"frame {row.frame}: Isochor's volume is {row.isochor_volume:.9f}, at rest {row.rest_volume:.9f}: "
                f"relative error {row.isochor_error:.2e}, allowed {VOLUME_TOLERANCE:.0e}"
            )
        if not abs(row.isochor_x / row.isochor_y - 1) <= ROUNDNESS_TOLERANCE:
            found.append(f"frame {row.frame}: not round from above, {row.isochor_x:.4f} by {row.isochor_y:.4f}")
        if row.marked_loss is not None and not abs(row.plain_change + row.marked_loss) <= LOSS_TOLERANCE:
            found.append(
                f"frame {row.frame}: the plain lattice changes the volume by {row.plain_change:+.1%}, "
                f"expected {-row.marked_loss:+.0%} within {LOSS_TOLERANCE:.0%}"
            )
    if not any(row.marked_loss is not None for row in rows):
        found.append("no frame is marked: the fixture's timeline markers are missing")
    return found
