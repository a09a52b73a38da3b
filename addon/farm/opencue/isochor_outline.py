#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Submits an OpenCue job that bakes the Volume Lattices of a file in chunks, joins them, and renders from the caches.

Use: python isochor_outline.py shot.blend --frames 1-240 --output DIR --render-output DIR/frame_####
The layers: bake (in chunks), join (when all are baked), report, and render (when joined). Needs pyoutline and pycue
(pip install opencue-pyoutline opencue-pycue). With --print the job's specification is printed and nothing is sent.
"""

import argparse
import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import outline
import outline.cuerun
from outline.constants import LayerType
from outline.modules.shell import Shell, ShellCommand

# Cuebot writes the ends of a frame's chunk in the place of these.
CHUNK = ("#FRAME_START#", "#FRAME_END#")
RENDER_SETTINGS = (
    "import bpy; render = bpy.context.scene.render; render.use_file_extension = True; render.use_overwrite = {}"
)


def main(words: Sequence[str]) -> None:
    options = parsed(words)
    launcher = outline.cuerun.OutlineLauncher(built(options), pause=options.pause)
    if options.print:
        print(launcher.serialize(use_pycuerun=False))
        return
    for job in launcher.launch(use_pycuerun=False):
        print(job.name())


def parsed(words: Sequence[str]) -> argparse.Namespace:
    """What the command line asks for; wrong words end the program with status 2 and a line that says why."""
    parser = argparse.ArgumentParser(description="Submits an OpenCue job that bakes, joins, reports and renders.")
    parser.add_argument("file", type=place, help="the blend file, where the farm's hosts see it")
    parser.add_argument("--frames", type=frame_range, required=True, metavar="FIRST-LAST", help="bake and render these")
    parser.add_argument("--output", type=place, required=True, help="folder of chunks, caches, report and baked file")
    parser.add_argument("--object", action="append", default=[], help="bake this object; again for more. Default: all")
    parser.add_argument("--bake-chunk", type=positive, default=20, help="frames to bake in one task (default: 20)")
    parser.add_argument("--format", choices=("pc2", "mdd"), default="pc2", help="file format of the caches")
    parser.add_argument("--samples", type=positive, default=1, help="samples to a frame, for motion blur (default: 1)")
    parser.add_argument("--allow-problems", action="store_true", help="do not fail where the volume could not be kept")
    parser.add_argument("--no-resume", action="store_true", help="bake chunks again that an earlier job has left")
    parser.add_argument("--no-report", action="store_true", help="do not write the volume by frame as CSV and PNG")
    parser.add_argument("--render-output", help="path of the frames, # for digits; without it nothing is rendered")
    parser.add_argument("--render-chunk", type=positive, default=1, help="frames to render in one task (default: 1)")
    parser.add_argument("--keep-frames", action="store_true", help="do not render frames again that are there already")
    parser.add_argument("--blender", default="blender", help="the Blender that the hosts run (default: blender)")
    parser.add_argument("--service", default="shell", help="OpenCue service of the layers (default: shell)")
    parser.add_argument("--name", help="name of the job (default: isochor_ and the file's name)")
    parser.add_argument("--show", help="default: SHOW or pyoutline's configuration")
    parser.add_argument("--shot", help="default: SHOT or pyoutline's configuration")
    parser.add_argument("--user", help="default: whoever submits")
    parser.add_argument("--pause", action="store_true", help="submit the job paused")
    parser.add_argument("--print", action="store_true", help="print the job's specification instead of sending it")
    return parser.parse_args(words)


def place(text: str) -> Path:
    """The path from the root on: a host has a working folder of its own."""
    return Path(text).absolute()


def frame_range(text: str) -> tuple[int, int]:
    """The ends of FIRST-LAST, or of one frame."""
    ends = re.fullmatch(r"(\d+)(?:-(\d+))?", text)
    if ends is None or int(ends[2] or ends[1]) < int(ends[1]):
        raise argparse.ArgumentTypeError(f"{text!r} is no frame range such as 1-240")
    return int(ends[1]), int(ends[2] or ends[1])


def positive(text: str) -> int:
    """A whole number of at least 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of frames")
    return int(text)


def built(options: argparse.Namespace) -> outline.Outline:
    """The outline: bake; join, which waits for it; report; render, which waits for the join."""
    name = re.sub(r"\W+", "_", options.name or f"isochor_{options.file.stem}", flags=re.ASCII)
    job = outline.Outline(name, frame_range=_range(options), show=options.show, shot=options.shot, user=options.user)
    bake = _add(job, Shell, "bake", _bake(options), options, LayerType.RENDER, chunk=options.bake_chunk)
    join = _add(job, ShellCommand, "join", _join(options), options, LayerType.UTIL)
    join.depend_all(bake)
    if not options.no_report:
        _add(job, ShellCommand, "report", _report(options), options, LayerType.UTIL)
    if options.render_output:
        render = _add(job, Shell, "render", _render(options), options, LayerType.RENDER, chunk=options.render_chunk)
        render.depend_all(join)
    return job


def _add(
    job: outline.Outline,
    module: type[outline.layer.Layer],
    name: str,
    command: list[str],
    options: argparse.Namespace,
    kind: LayerType,
    **more: int,
) -> outline.layer.Layer:
    """A layer of the job; its words are quoted, for a host runs them through a shell."""
    quoted, where = [shlex.quote(word) for word in command], {"service": options.service, "range": _range(options)}
    layer = module(name, command=quoted, type=kind, **where, **more)
    job.add_layer(layer)
    return layer


def _bake(options: argparse.Namespace) -> list[str]:
    resume = [] if options.no_resume else ["--resume"]
    chunk = [f"--frames={'-'.join(CHUNK)}", f"--part-of={_range(options)}"]
    return _isochor(options, "bake", [*chunk, *_caches(options), *_allowing(options), *resume])


def _join(options: argparse.Namespace) -> list[str]:
    whole = [f"--frames={_range(options)}", "--save", str(_baked(options))]
    return _isochor(options, "join", [*whole, *_caches(options)])


def _report(options: argparse.Namespace) -> list[str]:
    return _isochor(options, "report", [f"--frames={_range(options)}", *_allowing(options)])


def _isochor(options: argparse.Namespace, subcommand: str, words: list[str]) -> list[str]:
    start = [options.blender, "--background", "--command", "isochor", subcommand, str(options.file)]
    objects = [f"--object={name}" for name in options.object]
    return [*start, *words, *objects, "--output", str(options.output)]


def _caches(options: argparse.Namespace) -> list[str]:
    return [f"--format={options.format}", f"--samples={options.samples}"]


def _allowing(options: argparse.Namespace) -> list[str]:
    return ["--allow-problems"] if options.allow_problems else []


def _render(options: argparse.Namespace) -> list[str]:
    settings = ["--python-exit-code", "1", "--python-expr", RENDER_SETTINGS.format(not options.keep_frames)]
    first, last = CHUNK
    start = [options.blender, "--background", "--enable-autoexec", str(_baked(options))]
    return [*start, "--render-output", options.render_output, *settings, "-s", first, "-e", last, "-a"]


def _baked(options: argparse.Namespace) -> Path:
    """Where the join leaves the file that plays from the caches."""
    return options.output / f"{options.file.stem}-baked.blend"


def _range(options: argparse.Namespace) -> str:
    return "{}-{}".format(*options.frames)


if __name__ == "__main__":
    main(sys.argv[1:])
