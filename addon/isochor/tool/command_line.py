# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command isochor …`: batch work without a window, for scripts and render farms.

Ends with status 0 where all went well, 2 where the command line is wrong, else 1, with one plain line on the error
output.
"""

import argparse
import sys
from typing import NoReturn

import bpy

from ..core.point_cache import FORMATS
from ..core.problem import Problem
from . import bake_file, command_bake, command_join, command_report

NAME = "isochor"
FAILED, MISUSED = 1, 2

_registered: list[object] = []


class Misuse(Exception):
    """The command line itself is wrong."""


class Parser(argparse.ArgumentParser):
    """Tells what is wrong by an exception, since Blender's process is not the parser's to end."""

    def error(self, message: str) -> NoReturn:
        raise Misuse(f"{message} (see {self.prog} --help)")


def run(words: list[str]) -> int:
    """Does what the words behind `blender --command isochor` say; returns the status to end with."""
    try:
        options = parser().parse_args(words)
        options.run(options)
    except SystemExit as end:  # of --help
        return int(end.code or 0)
    except Misuse as trouble:
        return _fail(trouble, MISUSED)
    except (Problem, OSError) as trouble:
        return _fail(trouble, FAILED)
    return 0


def parser() -> Parser:
    """All commands and options."""
    top = Parser(prog=f"blender --command {NAME}", description="Bakes and reports what Volume Lattice does.")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    bake = _command(commands, "bake", command_bake.run, "write point caches of the deformed objects")
    _add_cache_options(bake)
    bake.add_argument(
        "--part-of",
        metavar="FIRST-LAST",
        help="the frames are a part of these: write it into DIR/parts, for join to put together",
    )
    bake.add_argument("--resume", action="store_true", help="keep parts that are there and sound; make the others")
    _add_allow_problems(bake)
    join = _command(commands, "join", command_join.run, "put the parts of a bake together")
    _add_cache_options(join)
    join.add_argument("--save", metavar="BLEND", help="also save a copy of FILE there that plays the caches")
    report = _command(commands, "report", command_report.run, "measure the volume frame by frame")
    report.add_argument("--output", metavar="DIR", help="folder for volume.csv and volume.png; else print the CSV")
    _add_allow_problems(report)
    return top


def _command(commands: "argparse._SubParsersAction[Parser]", name: str, run: object, summary: str) -> Parser:
    found = commands.add_parser(name, help=summary, description=f"{summary[0].upper()}{summary[1:]}.")
    found.set_defaults(run=run)
    found.add_argument("file", metavar="FILE", help="the .blend; it is not changed")
    found.add_argument("--frames", required=True, metavar="A-B", help="first and last frame, as in --frames=-5-10")
    found.add_argument(
        "--object", action="append", default=[], metavar="NAME", help="an object; again for more (default: all)"
    )
    return found


def _add_cache_options(command: Parser) -> None:
    command.add_argument("--output", required=True, metavar="DIR", help="folder for the files; made if missing")
    command.add_argument(
        "--format", type=str.upper, default=FORMATS[0], choices=FORMATS, help="of the point caches (default: pc2)"
    )
    command.add_argument(
        "--samples", type=_samples, default=1, metavar="N", help="samples to a frame, for motion blur (default: 1)"
    )


def _add_allow_problems(command: Parser) -> None:
    command.add_argument(
        "--allow-problems", action="store_true", help="do not fail where the volume could not be kept in some frame"
    )


def _samples(text: str) -> int:
    count = int(text)
    if not 1 <= count <= bake_file.FASTEST:
        raise argparse.ArgumentTypeError(f"must be from 1 to {bake_file.FASTEST}")
    return count


def _fail(trouble: Exception, status: int) -> int:
    sys.stdout.flush()
    print(f"{NAME}: {' '.join(str(trouble).split())}", file=sys.stderr, flush=True)
    return status


def register() -> None:
    """Makes the command known."""
    _registered.append(bpy.utils.register_cli_command(NAME, run))


def unregister() -> None:
    """Takes it back."""
    while _registered:
        bpy.utils.unregister_cli_command(_registered.pop())
