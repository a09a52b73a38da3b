# SPDX-License-Identifier: GPL-3.0-or-later
"""The files themselves: what stands in a point cache, byte by byte, and names that are safe for files."""

import hashlib
import json
import struct

import numpy as np
import pytest
import scenes

POSITIONS = np.arange(24, dtype=np.float32).reshape(2, 4, 3) / 7


def written(place, kind: str) -> bytes:
    point_cache = scenes.part("core.point_cache")
    layout = point_cache.Layout(4, 2, 10, 2, 25.0)
    data = point_cache.header(kind, layout) + b"".join(point_cache.sample(kind, shape) for shape in POSITIONS)
    place.write_bytes(data)
    return data


def test_pc2_byte_by_byte(tmp_path):
    data = written(tmp_path / "a.pc2", "PC2")
    assert data[:12] == b"POINTCACHE2\0"
    assert struct.unpack("<iiffi", data[12:32]) == (1, 4, 10.0, 0.5, 2)
    assert struct.unpack("<24f", data[32:]) == tuple(POSITIONS.reshape(-1))
    layout, found = scenes.part("core.point_cache").read(tmp_path / "a.pc2")
    assert (layout.vertices, layout.samples, layout.first_frame, layout.samples_per_frame) == (4, 2, 10.0, 2)
    assert np.array_equal(found, POSITIONS)


def test_mdd_byte_by_byte(tmp_path):
    data = written(tmp_path / "a.mdd", "MDD")
    assert struct.unpack(">iiff", data[:16]) == (2, 4, 0.0, pytest.approx(0.02))
    assert struct.unpack(">24f", data[16:]) == tuple(POSITIONS.reshape(-1))
    assert np.array_equal(scenes.part("core.point_cache").read(tmp_path / "a.mdd")[1], POSITIONS)


@pytest.mark.parametrize("kind", ["PC2", "MDD"])
def test_what_is_no_cache_is_refused(tmp_path, kind):
    read, error = scenes.part("core.point_cache").read, scenes.part("core.point_cache").NotACache
    place = tmp_path / f"a.{kind.lower()}"
    data = written(place, kind)
    for wrong in (b"", data[:7], data[:-1], data + b"\0", b"\xff" * len(data)):
        place.write_bytes(wrong)
        with pytest.raises(error):
            read(place)
    with pytest.raises(error):
        read(tmp_path / "a.txt")


@pytest.mark.parametrize(
    ("place", "values"),
    [(16, [-1]), (24, [-1, 0, 0x7FC00000, 1]), (28, [-1, 0])],
    ids=["vertices", "rate", "samples"],
)
def test_a_pc2_header_without_sense_is_refused(tmp_path, place, values):
    data = bytearray(written(tmp_path / "a.pc2", "PC2"))
    for value in values:
        data[place : place + 4] = struct.pack("<I", value & 0xFFFFFFFF)
        (tmp_path / "a.pc2").write_bytes(data)
        with pytest.raises(scenes.part("core.point_cache").NotACache):
            scenes.part("core.point_cache").read(tmp_path / "a.pc2")


def test_a_part_without_sense_is_damaged_whatever_its_head_says(tmp_path):
    part_file, joining = scenes.part("core.part_file"), scenes.part("core.joining")
    whole = {"object": "Ball", "blend": "ab", "first": 1, "last": 10, "samples": 1}
    sound = {"whole": whole, "start": 2, "end": 3, "vertices": 1, "asked": []}
    changes = [{"start": "2"}, {"start": 1.5}, {"start": 0}, {"end": 1}, {"vertices": None}, {"vertices": -1}]
    changes += [{"asked": [1]}, {"whole": {**whole, "samples": 0}}, {"whole": {**whole, "last": 2}}]
    (tmp_path / "folder.part").mkdir()
    for number, change in enumerate([{}, *changes]):
        text = part_file.MARK + json.dumps({**sound, **change}).encode() + b"\n" + bytes(24)
        (tmp_path / f"{number}.part").write_bytes(text + hashlib.sha256(text).digest())
    found = joining.find(tmp_path, part_file.Whole(**whole), range(10))
    assert [path.name for path, _head in found.parts] == ["0.part"]
    assert found.damaged == [f"{number}.part" for number in range(1, len(changes) + 1)]
    assert joining.asked_for(tmp_path, part_file.Whole(**whole)) == []


def test_an_atomic_file_is_there_whole_or_not_at_all(tmp_path):
    atomic = scenes.part("core.atomic_file").atomic
    place = tmp_path / "deep" / "file"
    with atomic(place) as file:
        file.write(b"one")
        assert not place.exists()
    assert place.read_bytes() == b"one"
    (tmp_path / "plain").touch()
    assert place.stat().st_mode == (tmp_path / "plain").stat().st_mode
    failing = atomic(place)
    failing.__enter__().write(b"two")
    failing.__exit__(KeyError, KeyError(), None)
    assert place.read_bytes() == b"one"
    assert [path.name for path in place.parent.iterdir()] == ["file"]


def test_names_are_safe_and_tell_objects_apart():
    names = ["Ball", "ball", "a/b", "a?b", "..", "nul", "NUL.txt", "x" * 300, "x" * 301, "Ünïcode 球", " a ", "a", "\n"]
    files = scenes.part("core.file_names").unique_names(names)
    assert len({file.casefold() for file in files}) == len(names)
    for file in files:
        assert len(f".{file}.1-1000x4.1-1000.part".encode()) < 255
        assert file == file.strip(" .")
        assert not set('/\\:*?"<>|\n') & set(file)
    assert files[9] == "Ünïcode 球"
    assert scenes.part("core.file_names").unique_names(["Ball"]) == ["Ball"]


def test_frame_ranges():
    parse, problem = scenes.part("core.frame_range").parse, scenes.part("core.problem").Problem
    assert parse("1-250", "--frames") == (1, 250)
    assert parse("7", "--frames") == (7, 7)
    assert parse("-10--5", "--frames") == (-10, -5)
    assert parse("-3..4", "--frames") == (-3, 4)
    for wrong in ("", "a-b", "1-", "1,2", "1.5-2", "5-1", "1-99999999"):
        with pytest.raises(problem, match="--frames"):
            parse(wrong, "--frames")
