# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing ball, from the built extension zip to frames, film strip, plot, animation and table.

    python addon/demo/bouncing_ball.py --zip dist/isochor-....zip --out out/bouncing-ball     (a Python with bpy)
    blender -b --factory-startup --python-exit-code 1 --python addon/demo/bouncing_ball.py -- --zip ... --out ...

Two child processes do the work: render_bounce.py in an isolated Blender, draw_pictures.py in a Python with Pillow and
matplotlib (this one, unless --pictures-python names another: Blender's own Python has neither). A second run with the
same extension, fixture and scripts finds everything up to date.
"""

import argparse
import hashlib
import importlib.util
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from blender_session import (  # noqa: E402
    DemoError,
    blender_program,
    command_arguments,
    isolated_environment,
    python_command,
    run_and_leave,
)
from bounce_table import VOLUME_TOLERANCE, BounceRow, complaints, read_table  # noqa: E402

FIXTURE = HERE.parents[1] / "blend_fixtures" / "bouncing_ball.blend"
STAMP = "up-to-date.sha256"
PICTURES = ("film-strip.png", "volume.png", "bounce.webp")


def fingerprint(zip_path: Path, fixture: Path) -> str:
    """Hash of all that the outcome depends on: the zip's members, the fixture, the demo's scripts, which Blender."""
    digest = hashlib.sha256(f"{blender_program()} {sys.version}".encode())
    with zipfile.ZipFile(zip_path) as archive:
        for member in archive.infolist():
            digest.update(f"{member.filename} {member.CRC}\n".encode())
    for path in (fixture, *sorted(HERE.glob("*.py"))):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def is_up_to_date(out: Path, expected: str) -> bool:
    """Whether `out` holds everything, made from the same input."""
    stamp = out / STAMP
    if not stamp.exists() or stamp.read_text() != expected or not (out / "volume.csv").exists():
        return False
    rows = read_table(out / "volume.csv")
    frames = [out / variant / f"{row.frame:04d}.png" for variant in ("plain", "isochor") for row in rows]
    return all(path.exists() for path in [*frames, *(out / name for name in PICTURES)])


def run_step(command: list[str], environment: dict[str, str] | None = None) -> None:
    """Runs a child process; DemoError if it fails."""
    sys.stdout.flush()
    status = subprocess.run(command, env=environment).returncode
    if status:
        raise DemoError(f"status {status} from: {' '.join(command)}")


def check_input(chosen: argparse.Namespace) -> None:
    """DemoError where something that the demo needs is missing."""
    for path, hint in ((chosen.zip, "run `make extension`"), (chosen.fixture, "run make_bouncing_ball.py")):
        if not path.is_file():
            raise DemoError(f"{path} does not exist; {hint} first.")
    if not blender_program() and importlib.util.find_spec("bpy") is None:
        raise DemoError(f"{sys.executable} has no bpy module; run this in Blender or in a Python with bpy installed.")
    probe = subprocess.run([chosen.pictures_python, "-c", "import PIL, matplotlib"], capture_output=True, text=True)
    if probe.returncode:
        raise DemoError(
            f"{chosen.pictures_python} cannot import Pillow and matplotlib ({probe.stderr.strip().splitlines()[-1]}); "
            "name a Python that can with --pictures-python."
        )


def clear(out: Path) -> None:
    """Takes away what an earlier run left in `out`, and nothing else."""
    out.mkdir(parents=True, exist_ok=True)
    for stale in (STAMP, "render.log", "volume.csv", *PICTURES):
        (out / stale).unlink(missing_ok=True)
    for folder in ("plain", "isochor", ".blender"):
        if (out / folder).exists():
            shutil.rmtree(out / folder)


def judge(rows: list[BounceRow]) -> None:
    """Prints the outcome; DemoError if the volume is not kept or the plain lattice does not lose what it should."""
    for row in (row for row in rows if row.marked_loss is not None):
        print(f"frame {row.frame}: plain lattice {row.plain_change:+.2%}, Isochor {row.isochor_error:+.1e}")
    worst = max(abs(row.isochor_error) for row in rows)
    print(f"largest error of Isochor's volume over {len(rows)} frames: {worst:.2e} (allowed {VOLUME_TOLERANCE:.0e})")
    found = complaints(rows)
    if found:
        raise DemoError("the bounce is not right:\n  " + "\n  ".join(found))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the built extension")
    parser.add_argument("--out", type=Path, required=True, help="folder for frames, pictures and table")
    parser.add_argument("--fixture", type=Path, default=FIXTURE, help="the .blend to render")
    parser.add_argument("--pictures-python", default=sys.executable, help="a Python with Pillow and matplotlib")
    chosen = parser.parse_args(command_arguments())
    check_input(chosen)
    out = chosen.out.resolve()
    expected = fingerprint(chosen.zip, chosen.fixture)
    if is_up_to_date(out, expected):
        judge(read_table(out / "volume.csv"))
        print(f"{out} is up to date")
        return
    clear(out)
    given = ["--zip", str(chosen.zip.resolve()), "--fixture", str(chosen.fixture.resolve()), "--out", str(out)]
    run_step(python_command(HERE / "render_bounce.py", given), isolated_environment(out / ".blender"))
    run_step([chosen.pictures_python, str(HERE / "draw_pictures.py"), "--out", str(out)])
    judge(read_table(out / "volume.csv"))
    (out / STAMP).write_text(expected)
    print(f"{out}: frames in plain/ and isochor/, {', '.join(PICTURES)}, volume.csv")


if __name__ == "__main__":
    run_and_leave(main)
