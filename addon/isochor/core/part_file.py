# SPDX-License-Identifier: GPL-3.0-or-later
"""A part of a bake: some frames of one object, with all that is needed to check it and to put it together with others.

One line of JSON behind a mark, then the vertices as little-endian float32, sample after sample, then the SHA-256 of
everything before it.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

MARK = b"Isochor part 1\n"
FOLDER = "parts"
SUFFIX = ".part"
_DIGEST = hashlib.sha256().digest_size
_BLOCK = 1 << 20
_LONGEST_HEAD = 1 << 16


class Damaged(ValueError):
    """The file is no part, or not as it was written."""


@dataclass(frozen=True)
class Whole:
    """The bake that parts belong to: the object's name, the SHA-256 of the .blend file (hexadecimal), the frames, both
    ends included, and the samples to a frame."""

    object: str
    blend: str
    first: int
    last: int
    samples: int

    @property
    def count(self) -> int:
        """Samples of the whole bake: the last frame has one."""
        return (self.last - self.first) * self.samples + 1

    def indices(self, start: int, end: int) -> range:
        """Which samples the frames from ``start`` to ``end``, both included, have: all up to the next frame."""
        return range((start - self.first) * self.samples, min((end - self.first + 1) * self.samples, self.count))

    def frame(self, index: int) -> int:
        """The frame that a sample belongs to."""
        return self.first + index // self.samples


@dataclass(frozen=True)
class Head:
    """Which part of which bake, the number of vertices, and the objects that the bake was asked for by name (none: all
    that there are)."""

    whole: Whole
    start: int
    end: int
    vertices: int
    asked: tuple[str, ...] = ()

    @property
    def indices(self) -> range:
        """Its samples among those of the whole bake."""
        return self.whole.indices(self.start, self.end)

    @property
    def size(self) -> int:
        """Bytes of one sample."""
        return self.vertices * 12


def file_name(name: str, whole: Whole, start: int, end: int) -> str:
    """What the part is called; ``name`` is the object's as a file name."""
    finely = "" if whole.samples == 1 else f"x{whole.samples}"
    return f"{name}.{whole.first}-{whole.last}{finely}.{start}-{end}{SUFFIX}"


class Writer:
    """Writes one part into an open file."""

    def __init__(self, file: BinaryIO, head: Head) -> None:
        self._file, self._digest = file, hashlib.sha256()
        self._write(MARK + json.dumps(asdict(head)).encode() + b"\n")

    def sample(self, positions: NDArray[np.floating[Any]]) -> None:
        """Adds the (V, 3) positions of the next sample."""
        self._write(np.ascontiguousarray(positions, "<f4").tobytes())

    def finish(self) -> None:
        """Adds what proves that the part is whole."""
        self._file.write(self._digest.digest())

    def _write(self, data: bytes) -> None:
        self._digest.update(data)
        self._file.write(data)


def read_head(path: Path) -> Head:
    """What the part says of itself. Raises Damaged or OSError."""
    with path.open("rb") as file:
        return _head(file)


def check(path: Path) -> Head:
    """Reads the whole part and proves that it is as it was written. Raises Damaged or OSError."""
    with path.open("rb") as file:
        head = _head(file)
        wanted = file.tell() + len(head.indices) * head.size + _DIGEST
        if path.stat().st_size != wanted:
            raise Damaged(f"{path.name} should have {wanted} bytes and has {path.stat().st_size}")
        file.seek(0)
        digest, left = hashlib.sha256(), wanted - _DIGEST
        while left:
            block = file.read(min(_BLOCK, left))
            if not block:
                break
            digest.update(block)
            left -= len(block)
        if file.read() != digest.digest():
            raise Damaged(f"{path.name} is not as it was written")
    return head


def samples(path: Path, wanted: range) -> Iterator[NDArray[np.float32]]:
    """(V, 3) positions of these samples of the whole bake, which the checked part must hold."""
    with path.open("rb") as file:
        head = _head(file)
        file.seek((wanted.start - head.indices.start) * head.size, 1)
        for _index in wanted:
            yield np.frombuffer(file.read(head.size), "<f4").reshape(-1, 3)


def _head(file: BinaryIO) -> Head:
    """Reads up to the first sample."""
    if file.read(len(MARK)) != MARK:
        raise Damaged(f"{Path(file.name).name} is no part of a bake")
    try:
        found = json.loads(file.readline(_LONGEST_HEAD))
        head = Head(Whole(**found.pop("whole")), asked=tuple(found.pop("asked")), **found)
        if _makes_sense(head):
            return head
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise Damaged(f"{Path(file.name).name} has a damaged head") from error
    raise Damaged(f"{Path(file.name).name} has a head that makes no sense")


def _makes_sense(head: Head) -> bool:
    """Whether the head of an unchecked file holds what its types say, and frames in order."""
    whole = head.whole
    numbers = (whole.first, whole.last, whole.samples, head.start, head.end, head.vertices)
    return (
        all(type(number) is int for number in numbers)
        and all(isinstance(text, str) for text in (whole.object, whole.blend, *head.asked))
        and whole.first <= head.start <= head.end <= whole.last
        and whole.samples >= 1
        and head.vertices >= 0
    )
