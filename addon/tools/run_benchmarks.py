# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the benchmarks: of the wheel against the paper's own formulation, and of a frame in Blender.

Use: python run_benchmarks.py, or with --gpu those of the GPU alone; what follows --gpu goes to gpu_bench.py.
"""

import sys

import blenders
import build_extension
import build_wheel
import environments
from workspace import ROOT, as_program, fail, say, status

PLACE = ROOT / "tests" / "benchmarks"


def main() -> None:
    say("the wheel alone")
    alone = status([environments.install_wheel("native", build_wheel.wheel()), PLACE / "native_bench.py"])
    blender = blenders.preferred()
    zip_file = build_extension.extension()
    say(f"a frame in {blender.name}")
    framed = status(blender.command(PLACE / "frame_bench.py", "--zip", zip_file), blender.isolation("bench"))
    if alone or framed:
        fail("a benchmark missed its target: see its table above")


def gpu(arguments: list[str]) -> None:
    python = environments.install_wheel("gpu-bench", build_wheel.wheel())
    if status([python, PLACE / "gpu_bench.py", *arguments]):
        fail("the GPU's benchmark did not run, or missed a target: see above")


if __name__ == "__main__":
    as_program(lambda: gpu(sys.argv[2:]) if sys.argv[1:2] == ["--gpu"] else main())
