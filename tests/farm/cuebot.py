# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the OpenCue outline as far as its job specification, and makes of that the frames as Cuebot dispatches them.

After OpenCue 1.37: a layer has one frame a chunk, in whose command #FRAME_START# and #FRAME_END# are replaced; a host
runs it as a shell script.
"""

import os
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import grpc
from opencue_proto import cue_pb2, cue_pb2_grpc, job_pb2, job_pb2_grpc
from places import FARM
from running import Task, ran


@dataclass(frozen=True)
class Layer:
    """One layer of the specification."""

    name: str
    command: str
    range: str
    chunk: int

    def frames(self) -> list[tuple[str, str]]:
        """Name and command of each frame that is dispatched."""
        first, last = (int(end) for end in (self.range.split("-") * 2)[:2])
        found = []
        for start in range(first, last + 1, self.chunk):
            end = min(last, start + self.chunk - 1)
            command = self.command.replace("#FRAME_START#", str(start)).replace("#FRAME_END#", str(end))
            found.append((f"{start:04d}-{self.name}", command))
        return found


class Spec:
    """A job specification as Cuebot reads it."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)
        job = self.root.find("job")
        self.name = job.get("name")
        self.layers = [
            Layer(layer.get("name"), layer.findtext("cmd"), layer.findtext("range"), int(layer.findtext("chunk")))
            for layer in job.iter("layer")
        ]
        depends = list(self.root.find("depends"))
        assert all(depend.get("type") == "LAYER_ON_LAYER" for depend in depends)
        self.depends = {(depend.findtext("deplayer"), depend.findtext("onlayer")) for depend in depends}

    def tasks(self) -> list[Task]:
        """Every frame of the job, with the frames that it waits for."""
        frames = [(layer.name, *frame) for layer in self.layers for frame in layer.frames()]
        on = {name: {other for one, other in self.depends if one == name} for name, _, _ in frames}
        return [
            Task(frame, [["sh", "-c", command]], tuple(i for i, other in enumerate(frames) if other[0] in on[name]))
            for name, frame, command in frames
        ]


def printed(words: Sequence[str | Path], sessions: Path) -> str:
    """The specification that would be sent."""
    status, output = ran_submitter([*words, "--print"], sessions)
    assert status == 0, output
    return output[output.index("<?xml") :]


def ran_submitter(words: Sequence[str | Path], sessions: Path, server: str = "") -> tuple[int, str]:
    """Exit status and output of the program that submits; pyoutline keeps its sessions in that folder."""
    program = [sys.executable, str(FARM / "opencue" / "isochor_outline.py"), *map(str, words)]
    return ran(program, env={**os.environ, "OUTLINE_OUTLINE_SESSION_DIR": str(sessions), "CUEBOT_HOSTS": server})


class _Statistics(cue_pb2_grpc.CueInterfaceServicer):
    """What a client asks first, to see whether somebody answers."""

    def GetSystemStats(self, request, context):  # noqa: N802
        return cue_pb2.CueGetSystemStatsResponse()


class _Jobs(job_pb2_grpc.JobInterfaceServicer):
    """Takes specifications and keeps them."""

    def __init__(self) -> None:
        self.taken: list[str] = []

    def LaunchSpecAndWait(self, request, context):  # noqa: N802
        self.taken.append(request.spec)
        job = job_pb2.Job(id="1", name=f"film-010-somebody_{Spec(request.spec).name}")
        return job_pb2.JobLaunchSpecAndWaitResponse(jobs=job_pb2.JobSeq(jobs=[job]))


@contextmanager
def listening() -> Iterator[tuple[str, list[str]]]:
    """A server on this machine that speaks Cuebot's protocol as far as submitting goes: where, and what it was sent."""
    jobs, server = _Jobs(), grpc.server(ThreadPoolExecutor(1))
    cue_pb2_grpc.add_CueInterfaceServicer_to_server(_Statistics(), server)
    job_pb2_grpc.add_JobInterfaceServicer_to_server(jobs, server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    try:
        yield f"127.0.0.1:{port}", jobs.taken
    finally:
        server.stop(None)
