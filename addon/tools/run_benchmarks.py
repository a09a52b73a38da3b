# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the benchmarks: of the wheel against the paper's own formulation, and of a frame in Blender.

Use: python run_benchmarks.py.
"""

import blenders
import build_extension
import build_wheel
import environments
from workspace import ROOT, as_program, run, say

PLACE = ROOT / "tests" / "benchmarks"


def main() -> None:
    say("the wheel alone")
    run([environments.install_wheel("native", build_wheel.wheel()), PLACE / "native_bench.py"])
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    say(f"a frame in {blender.name}")
    run(blender.command(PLACE / "frame_bench.py", "--zip", zip_file), blender.isolation("bench"))


if __name__ == "__main__":
    as_program(main)
