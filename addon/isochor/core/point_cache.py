# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches as Blender's Mesh Cache modifier and other programs read them: PC2 and MDD.

Both hold every vertex of every sample as three float32, one sample after the other, behind a short header; PC2 is
little-endian, MDD big-endian.
"""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Format = Literal["PC2", "MDD"]
FORMATS: tuple[Format, ...] = ("PC2", "MDD")
SUFFIXES: dict[Format, str] = {"PC2": ".pc2", "MDD": ".mdd"}
NUMBERS: dict[Format, np.dtype[Any]] = {"PC2": np.dtype("<f4"), "MDD": np.dtype(">f4")}

_PC2_MAGIC = b"POINTCACHE2\0"
_PC2 = struct.Struct("<12siiffi")
_MDD = struct.Struct(">ii")
_SLOWEST_RATE = 1e-6
"""Frames from one sample to the next, at the least; whole frames are the most."""


class NotACache(ValueError):
    """The file is not what its name says, or holds less or more than its header says."""


@dataclass(frozen=True)
class Layout:
    """How many vertices and samples; the frame of the first sample; samples to a frame. PC2 keeps all of them, MDD
    the times in seconds after the first sample instead of the last two, which take ``frames_per_second``."""

    vertices: int
    samples: int
    first_frame: float
    samples_per_frame: int = 1
    frames_per_second: float = 24.0


def header(kind: Format, layout: Layout) -> bytes:
    """What stands in the file before the vertices."""
    if kind == "PC2":
        return _PC2.pack(
            _PC2_MAGIC, 1, layout.vertices, layout.first_frame, 1.0 / layout.samples_per_frame, layout.samples
        )
    seconds = np.arange(layout.samples) / (layout.samples_per_frame * layout.frames_per_second)
    return _MDD.pack(layout.samples, layout.vertices) + seconds.astype(">f4").tobytes()


def sample(kind: Format, positions: NDArray[np.floating[Any]]) -> bytes:
    """One sample as it stands in the file, of (V, 3) positions."""
    return np.ascontiguousarray(positions, NUMBERS[kind]).tobytes()


def read(path: Path) -> tuple[Layout, NDArray[np.float32]]:
    """What the file holds, and its samples, (S, V, 3), as a view of the file. Raises NotACache or OSError."""
    kind = next((kind for kind in FORMATS if path.suffix.lower() == SUFFIXES[kind]), None)
    if kind is None:
        raise NotACache(f"{path.name} is named neither .pc2 nor .mdd")
    with path.open("rb") as file:
        layout, start = _read_pc2_header(file.read(_PC2.size)) if kind == "PC2" else _read_mdd_header(file.read(8))
    wanted = start + layout.samples * layout.vertices * 12
    found = path.stat().st_size
    if found != wanted:
        raise NotACache(f"{path.name} should have {wanted} bytes and has {found}")
    shape = (layout.samples, layout.vertices, 3)
    values: NDArray[np.float32] = np.memmap(path, NUMBERS[kind], "r", start, shape)
    return layout, values


def _read_pc2_header(head: bytes) -> tuple[Layout, int]:
    if len(head) < _PC2.size:
        raise NotACache("the header is cut off")
    magic, version, vertices, first, rate, samples = _PC2.unpack(head)
    is_rate = _SLOWEST_RATE <= rate <= 1.0
    if magic != _PC2_MAGIC or version != 1 or not is_rate or samples < 1 or vertices < 0:
        raise NotACache("the header is not that of a PC2 file")
    return Layout(vertices, samples, first, round(1.0 / rate)), _PC2.size


def _read_mdd_header(head: bytes) -> tuple[Layout, int]:
    if len(head) < _MDD.size:
        raise NotACache("the header is cut off")
    samples, vertices = _MDD.unpack(head)
    if samples < 1 or vertices < 0:
        raise NotACache("the header is not that of an MDD file")
    return Layout(vertices, samples, 0.0), _MDD.size + 4 * samples
