# SPDX-License-Identifier: GPL-3.0-or-later
"""Times of the GPU path beside the CPU's, the copy bandwidth of the card and the volume paper's own formulation.

    python tests/benchmarks/gpu_bench.py [--device NAME] [--largest N] [--repeats N]

Procedural meshes with the vertex counts of the paper's tables 1 and 2, one million and ten million, in uniform cubic
lattices of 10³ and 6³ control points. Medians after a warm-up: of the GPU's own clock for the whole pipeline (FFD,
three axes, final FFD), and of the wall with everything that a caller waits for. On a graphics card the results are
written into native/gpu/BENCHMARKS.md, with a plot beside it; a software rasteriser is no hardware: it runs, for its
errors, and nothing is written. Exit status 1 if a target is missed, or the volume is off.
"""

from __future__ import annotations

import argparse
import datetime
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import isochor
import numpy as np
from isochor._native import copy_bandwidth
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "native"))
import lattices
from native_bench import Paper, bumpy_sphere
from oracle import Spec

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "native" / "gpu" / "BENCHMARKS.md"
PLOT = TABLE.with_name("time_by_vertices.svg")
MARKS = ("<!-- results: written by `make bench-gpu` -->", "<!-- end of results -->")

SIZES = [2_562, 5_247, 19_851, 31_947, 52_971, 137_062, 327_323, 437_645, 543_652, 1_000_000, 10_000_000]
GRIDS = [10, 6]
PAPERS_LARGEST, LARGE, HUGE = 437_645, 1_000_000, 10_000_000
SOFTWARE_LARGEST = 543_652
ERROR = 1e-6  # what float32 vertices are promised
DELTA = 1e-4  # δ against the paper's in float32, of its length
PIPELINE_S = 0.25e-3  # at PAPERS_LARGEST, on an H200-class GPU
TIMES_THE_COPIES = 3.0  # at HUGE: of four passes over 60 bytes a vertex and 12 a triangle
FASTER, SMALLER = 5.0, 20.0  # than the paper's formulation on the same GPU, at HUGE
# linear growth: time a vertex at HUGE over that at 1 million; fixed costs make smaller meshes dearer, never cheaper
GROWTH = 1.5


@dataclass
class Row:
    """What was measured at one size."""

    vertices: int
    triangles: int
    points: int
    device_s: float | None
    wall_s: float
    cpu_s: float
    error: float
    bytes: int
    paper_s: float | None = None
    paper_bytes: int | None = None
    paper_delta: float | None = None

    @property
    def four_passes(self) -> int:
        return 4 * (60 * self.vertices + 12 * self.triangles)


def mesh(count: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """A bumpy sphere with exactly so many vertices: those beyond full rings split a triangle each."""
    rings = int((1 + np.sqrt(2 * count - 3)) / 2)
    points, triangles = bumpy_sphere(rings)
    missing = count - len(points)
    split = triangles[:missing]
    middles = np.arange(len(points), count, dtype=np.int32)
    a, b, c = split.T
    parts = [np.stack(corners, 1) for corners in ((a, b, middles), (b, c, middles), (c, a, middles))]
    points = np.concatenate([points, points[split].mean(axis=1)])
    return points.astype(np.float32), np.concatenate([*parts, triangles[missing:]]).astype(np.int32)


def median_of(call, repeats: int) -> tuple[float, list]:
    """Median seconds of the wall, and what the timed calls gave; the first call does not count."""
    call()
    took, gave = [], []
    for _ in range(repeats):
        start = time.perf_counter()
        gave.append(call())
        took.append(time.perf_counter() - start)
    return median(took), gave


def measured(count: int, points: int, device: str, repeats: int) -> Row:
    vertices, triangles = mesh(count)
    assert len(vertices) == count
    spec = Spec((points, points, points), "bspline", 3, "uniform")
    control = lattices.deformed(spec, "squash", 0.5) + 0.02 * np.sin(7 * spec.rest[..., ::-1])
    on_gpu = spec.build().bind(vertices, triangles, device=device)
    wall, results = median_of(lambda: on_gpu.preserve(control, method="sweep"), repeats)
    assert {result.device for result in results} == {"gpu"}, "the CPU took over"
    on_cpu = spec.build().bind(vertices, triangles, device="cpu")
    cpu, _ = median_of(lambda: on_cpu.preserve(control, method="sweep"), repeats)
    seconds = [result.device_seconds for result in results if result.device_seconds is not None]
    row = Row(
        vertices=count,
        triangles=len(triangles),
        points=points,
        device_s=median(seconds) if seconds else None,
        wall_s=wall,
        cpu_s=cpu,
        error=max(result.error for result in results),
        bytes=on_gpu.device_bytes,
    )
    add_paper(row, spec, vertices, triangles, control, results[0].control - control, repeats)
    return row


def add_paper(row: Row, spec: Spec, vertices, triangles, control, delta, repeats: int) -> None:
    """The paper's formulation on the same GPU, where CuPy is there and its matrices fit."""
    try:
        from paper_on_gpu import PaperOnGpu
    except ImportError:
        return
    if spec.shape[0] != GRIDS[0]:
        return
    reference = Paper.volume(Paper(triangles, None, None), vertices.astype(float))
    try:
        paper = PaperOnGpu.of(spec, vertices, triangles)
        row.paper_s = paper.median_seconds(control, reference, repeats)
    except MemoryError as reason:
        print(f"paper's matrices at {row.vertices:,} vertices: {reason}")
        return
    row.paper_bytes = paper.bytes
    expected = paper.delta(control, reference)
    row.paper_delta = float(np.linalg.norm(delta.reshape(-1, 3) - expected) / np.linalg.norm(expected))


def seconds(rows: dict[int, Row], count: int) -> float | None:
    """Of the GPU's clock at one size, where it was measured."""
    return rows[count].device_s if count in rows else None


def ratio(upper: float | None, lower: float | None) -> float | None:
    return upper / lower if upper is not None and lower is not None else None


def judged(rows: list[Row], bandwidth: float) -> list[tuple[str, str, bool | None]]:
    """Every target: what it is, what was found, whether it is met (None: could not be judged)."""
    big = {row.vertices: row for row in rows if row.points == GRIDS[0]}
    verdicts: list[tuple[str, str, bool | None]] = []

    def judge(title: str, found: float | None, limit: float, form: str, most: bool = True) -> None:
        met = None if found is None else (found <= limit if most else found >= limit)
        verdicts.append((title, "not measured" if found is None else form.format(found), met))

    pipeline = ratio(seconds(big, PAPERS_LARGEST), PIPELINE_S)
    judge(f"whole pipeline at {PAPERS_LARGEST:,} vertices ≤ 0.25 ms", pipeline, 1.0, "{:.2f} of it")
    huge, huge_s = big.get(HUGE), seconds(big, HUGE)
    copies = ratio(huge_s, huge.four_passes / bandwidth) if huge else None
    judge(f"{HUGE:,} vertices ≤ 3 × four passes at copy speed", copies, TIMES_THE_COPIES, "{:.2f} ×")
    faster = ratio(huge.paper_s, huge_s) if huge else None
    judge(f"≥ 5 × faster than the paper's formulation at {HUGE:,}", faster, FASTER, "{:.1f} ×", most=False)
    smaller = ratio(huge.paper_bytes, huge.bytes) if huge else None
    judge(f"≥ 20 × less device memory than it at {HUGE:,}", smaller, SMALLER, "{:.1f} ×", most=False)
    deltas = [row.paper_delta for row in rows if row.paper_delta is not None]
    judge("same δ as the paper's in float32", max(deltas, default=None), DELTA, "{:.1e} of its length")
    growth = ratio(ratio(huge_s, HUGE), ratio(seconds(big, LARGE), LARGE))
    judge("linear growth: time a vertex at 10 million over that at 1 million ≤ 1.5", growth, GROWTH, "{:.2f} ×")
    judge("relative error of the volume ≤ 1e-6", max(row.error for row in rows), ERROR, "{:.1e}")
    return verdicts


def cell(value: float | None, scale: float = 1.0, form: str = "{:.3f}") -> str:
    return "" if value is None else form.format(value * scale)


def table(rows: list[Row], bandwidth: float) -> str:
    head = (
        "| vertices | grid | GPU clock (ms) | wall (ms) | CPU wall (ms) | four passes at copy speed (ms) "
        "| volume error | MiB on the GPU | paper's CSR (ms) | its MiB |"
    )
    lines = [head, "|" + "---:|" * 10]
    for row in rows:
        cells = [
            f"{row.vertices:,}",
            f"{row.points}³",
            cell(row.device_s, 1e3),
            cell(row.wall_s, 1e3),
            cell(row.cpu_s, 1e3),
            cell(row.four_passes / bandwidth, 1e3),
            cell(row.error, form="{:.1e}"),
            cell(row.bytes, 2**-20, "{:.1f}"),
            cell(row.paper_s, 1e3),
            cell(row.paper_bytes, 2**-20, "{:.1f}"),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def crossing(rows: list[Row]) -> str:
    """From how many vertices on the GPU is faster, by the wall."""
    faster = [row.vertices for row in rows if row.points == GRIDS[0] and row.wall_s < row.cpu_s]
    return f"{min(faster):,} vertices" if faster else "no size measured"


def report(rows: list[Row], device: isochor.Device, bandwidth: float, verdicts) -> str:
    marks = {True: "met", False: "MISSED", None: "not judged"}
    shown = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    commit = shown.stdout.strip()
    cpu = isochor.devices()[-1].name
    return "\n".join(
        [
            f"{device.name} ({device.backend}) and {cpu}; {datetime.date.today()}; commit {commit}.",
            f"Copy bandwidth measured in the same run: {bandwidth / 1e9:.0f} GB/s (read and written bytes).",
            f"The GPU is faster, by the wall, from {crossing(rows)} on.",
            "",
            table(rows, bandwidth),
            "",
            "| target | found | |",
            "|---|---|---|",
            *(f"| {title} | {found} | {marks[met]} |" for title, found, met in verdicts),
            "",
            f"![time against vertices]({PLOT.name})",
        ]
    )


def plot(rows: list[Row], device: isochor.Device) -> None:
    """Time against vertices for CPU and GPU, the paper's figure 9."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    chosen = [row for row in rows if row.points == GRIDS[0]]
    counts = [row.vertices for row in chosen]
    pyplot.figure(figsize=(7, 4.5))
    pyplot.loglog(counts, [row.cpu_s * 1e3 for row in chosen], "o-", label="CPU, wall")
    pyplot.loglog(counts, [row.wall_s * 1e3 for row in chosen], "s-", label=f"{device.name}, wall")
    if all(row.device_s for row in chosen):
        pyplot.loglog(
            counts, [(row.device_s or 0) * 1e3 for row in chosen], "^-", label=f"{device.name}, its own clock"
        )
    pyplot.xlabel("vertices")
    pyplot.ylabel("ms: FFD, three axes, final FFD")
    pyplot.grid(True, which="both", alpha=0.3)
    pyplot.legend()
    pyplot.tight_layout()
    pyplot.savefig(PLOT, metadata={"Date": None})


def write(text: str) -> None:
    """Puts the results between their marks."""
    before, rest = TABLE.read_text().split(MARKS[0])
    TABLE.write_text(f"{before}{MARKS[0]}\n\n{text}\n\n{MARKS[1]}{rest.split(MARKS[1])[1]}")
    print(f"written: {TABLE.relative_to(ROOT)} and {PLOT.relative_to(ROOT)}")


def chosen_device(name: str | None) -> isochor.Device:
    found = [device for device in isochor.devices() if device.kind != "cpu" and name in (None, device.name)]
    if not found:
        raise SystemExit(f"gpu_bench.py: no adapter {name or ''} among {isochor.devices()}")
    return found[0]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default=None, help="name of the adapter (default: the best)")
    parser.add_argument("--largest", type=int, default=max(SIZES), help="leave larger meshes out")
    parser.add_argument("--repeats", type=int, default=25, help="timed runs of each call")
    options = parser.parse_args()
    device = chosen_device(options.device)
    is_hardware = device.kind == "gpu"
    bandwidth = copy_bandwidth(device.name)
    # A software rasteriser is there for the results, not for times; its buffers end at 128 MiB.
    largest = options.largest if is_hardware else min(options.largest, SOFTWARE_LARGEST)
    sizes = [size for size in SIZES if size <= largest]
    rows = []
    for points in GRIDS:
        for size in sizes:
            rows.append(measured(size, points, device.name, options.repeats))
            print(f"{size:,} vertices, {points}³: done, relative error of the volume {rows[-1].error:.1e}", flush=True)
    if not is_hardware:
        print(f"{device.name} is a software rasteriser: its times say nothing about a GPU, and none are given")
        return 0 if max(row.error for row in rows) <= ERROR else 1
    verdicts = judged(rows, bandwidth)
    text = report(rows, device, bandwidth, verdicts)
    print(text)
    if options.largest >= max(SIZES):
        plot(rows, device)
        write(text)
    return 1 if any(met is False for *_, met in verdicts) else 0


if __name__ == "__main__":
    sys.exit(main())
