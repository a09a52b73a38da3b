# SPDX-License-Identifier: GPL-3.0-or-later
"""What one picture of the gallery is, and the table that a page's pictures fill."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

COLUMNS = 4
"""Pictures side by side, where a page does not say."""


@dataclass(frozen=True)
class Tile:
    """One picture: its caption, and the name of the object whose volume is measured against what it must be.

    ``whole`` is the volume at rest and ``must_be`` the one promised, in units of the object's own space; None says that
    nothing is promised, as under Blender's own Lattice modifier. ``note`` is said after the volume.
    """

    caption: str
    object_name: str
    whole: float
    must_be: float | None
    note: str = ""


@dataclass(frozen=True)
class Shot:
    """A picture that was rendered, and the volume that was measured on it. ``columns``: of its page."""

    page: str
    file: str
    caption: str
    volume: float
    whole: float
    must_be: float | None
    note: str = ""
    columns: int = COLUMNS

    @property
    def error(self) -> float | None:
        """Relative error of the volume, or None where nothing is promised."""
        return None if self.must_be is None else abs(self.volume / self.must_be - 1.0)


def write_shots(place: Path, shots: list[Shot]) -> None:
    """Keeps the pictures' table for those who draw the pages."""
    place.write_text(json.dumps([asdict(shot) for shot in shots], indent=1), encoding="utf-8")


def read_shots(place: Path) -> list[Shot]:
    """What write_shots kept."""
    return [Shot(**row) for row in json.loads(place.read_text(encoding="utf-8"))]


def write_csv(place: Path, shots: list[Shot]) -> None:
    """The same table for a spreadsheet."""
    lines = ["page,picture,caption,volume,volume at rest,promised,relative error"]
    for shot in shots:
        promised = "" if shot.must_be is None else f"{shot.must_be:.9g}"
        error = "" if shot.error is None else f"{shot.error:.1e}"
        words = [shot.page, shot.file, f'"{shot.caption}"', f"{shot.volume:.9g}", f"{shot.whole:.9g}", promised, error]
        lines.append(",".join(words))
    place.write_text("\n".join(lines) + "\n", encoding="utf-8")
