# SPDX-License-Identifier: GPL-3.0-or-later
"""Where things are in the clone, and how the tools run a command and speak to the person who called them."""

import hashlib
import os
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / ".build"
DIST = ROOT / "dist"
OUT = ROOT / "out"


# The words of a command.
Command = Sequence[str | Path]


class Unavailable(Exception):
    """Something this machine does not have and that cannot be had; the text is one line for the user."""


def say(text: str) -> None:
    """Prints one line of progress at once, so that it stands before the output of the next command."""
    print(f"isochor: {text}", flush=True)


def fail(text: str) -> None:
    """Prints the line on stderr and ends the program with status 1."""
    print(f"isochor: {text}", file=sys.stderr, flush=True)
    raise SystemExit(1)


def as_program(main: Callable[[], None]) -> None:
    """Runs a tool; what cannot be had or failed ends the program with status 1 and one line, not a traceback."""
    try:
        main()
    except (Unavailable, subprocess.CalledProcessError) as reason:
        fail(str(reason))


@contextmanager
def alone(purpose: str) -> Iterator[None]:
    """Lets one process at a time of this clone build what the purpose names; the others wait."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / f"{purpose}.lock").open("w") as file:
        _lock(file)
        yield


def _lock(file: IO[str]) -> None:
    """Waits until this process alone holds the file, until it closes it."""
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)


def in_ci() -> bool:
    """True where the environment says CI=true: there nothing may be skipped."""
    return os.environ.get("CI", "").lower() in {"1", "true", "yes"}


def run(command: Command, env: Mapping[str, str] | None = None, cwd: Path = ROOT) -> None:
    """Runs a command with its output shown; raises CalledProcessError where it fails."""
    subprocess.run([str(part) for part in command], check=True, cwd=cwd, env=environment(env))


def status(command: Command, env: Mapping[str, str] | None = None, cwd: Path = ROOT) -> int:
    """Runs a command with its output shown and returns its exit status."""
    return subprocess.run([str(part) for part in command], check=False, cwd=cwd, env=environment(env)).returncode


def logged_status(command: Command, log: Path) -> int:
    """Runs a command with its output appended to the log instead of shown, and returns its exit status."""
    with log.open("ab") as file:
        file.write(f"\n$ {shown(command)}\n".encode())
        file.flush()
        done = subprocess.run([str(part) for part in command], check=False, cwd=ROOT, stdout=file, stderr=file)
    return done.returncode


def output(command: Command) -> str | None:
    """The command's standard output without the surrounding blanks, or None where it cannot be run or fails."""
    try:
        done = subprocess.run([str(part) for part in command], check=False, capture_output=True, text=True)
    except OSError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def shown(command: Command) -> str:
    """The command as one would type it."""
    return shlex.join(str(part) for part in command)


def fingerprint(paths: Iterable[Path], *words: str) -> str:
    """A digest of the words and of the names and contents of all files at and below the paths."""
    digest = hashlib.sha256("\0".join(words).encode())
    for path in sorted(file for start in paths for file in _files(start)):
        digest.update(f"\0{path.relative_to(ROOT)}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def is_fresh(stamp: Path, digest: str) -> bool:
    """True where the stamp file holds this digest."""
    return stamp.is_file() and stamp.read_text() == digest


def _files(start: Path) -> list[Path]:
    if start.is_file():
        return [start]
    return [file for file in start.rglob("*") if file.is_file() and "__pycache__" not in file.parts]


def environment(extra: Mapping[str, str] | None) -> dict[str, str]:
    """The environment of this process with these variables set on top."""
    return {**os.environ, **(extra or {})}
