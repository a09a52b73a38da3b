# SPDX-License-Identifier: GPL-3.0-or-later
"""Times of the native library beside the volume paper's own formulation, and the volume errors that it reaches.

    python tests/benchmarks/native_bench.py [--quick] [--repeats N]

The paper's formulation (Hahmann et al. 2012, sections 5 and 6) is a sparse CSR matrix of N control points × F faces,
built beforehand, whose product with the faces' area vectors gives α, β and γ; a second CSR matrix of V × N weights,
also built beforehand, deforms the vertices. Both run in scipy on one thread, as its products do. All figures are
medians of one run. Exit status 1 if a target is missed or the two disagree.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

import isochor
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "native"))
import lattices
import meshes
import oracle
from oracle import Spec

RATIO_TARGET = 1 / 10
UNIFORM = Spec((10, 10, 10), "bspline", 3, "uniform")
JUDGED_FROM = (
    400_000  # vertices; the target is for 440 thousand, and what is fixed per call weighs more in small meshes
)
MILLI = 1e3


@dataclass
class Paper:
    """The paper's correction with both matrices in CSR, for a mesh that lies inside its lattice."""

    triangles: NDArray
    weights: sparse.csr_matrix  # (V, N): B_ijk(u_v)
    faces: sparse.csr_matrix  # (N, F): (B_ijk(u_l) + B_ijk(u_m) + B_ijk(u_n)) / 6

    @classmethod
    def of(cls, spec: Spec, vertices: NDArray, triangles: NDArray) -> Paper:
        weights = sparse_weights(spec, vertices)
        count = len(triangles)
        ones = np.ones(3 * count)
        corners = sparse.csr_matrix(
            (ones, triangles.ravel(), np.arange(0, 3 * count + 1, 3)), shape=(count, len(vertices))
        )
        faces = ((corners @ weights).T / 6).tocsr()
        return cls(triangles, weights, faces)

    def deform(self, control: NDArray) -> NDArray:
        return self.weights @ control

    def determinants(self, vertices: NDArray, axis: int) -> NDArray:
        """(F,): the determinant of equation (10), (11) or (12), twice the faces' area seen along `axis`."""
        (al, am, an), (bl, bm, bn) = (vertices[:, (axis + turn) % 3][self.triangles.T] for turn in (1, 2))
        return (am - al) * (bn - bl) - (an - al) * (bm - bl)

    def volume(self, vertices: NDArray) -> float:
        """Equation (5), along z."""
        return float(vertices[:, 2][self.triangles.T].sum(axis=0) @ self.determinants(vertices, 2)) / 6

    def sweep(self, control: NDArray, reference: float) -> tuple[NDArray, NDArray]:
        """Control points (N, 3) and vertices after x, y and z have each taken a third: equations (13)-(17)."""
        control = control.copy()
        vertices = np.asfortranarray(self.deform(control))
        part = (reference - self.volume(vertices)) / 3
        for axis in range(3):
            coefficients = self.faces @ self.determinants(vertices, axis)
            control[:, axis] += part / (coefficients @ coefficients) * coefficients
            vertices[:, axis] = self.weights @ control[:, axis]
        return control, vertices


def sparse_weights(spec: Spec, vertices: NDArray) -> sparse.csr_matrix:
    """(V, N) tensor-product weights, nonzero taps only; vertices must lie inside the domain."""
    parameters = np.clip(spec.parameters(vertices), 0, 1)
    taps = [sparse_axis(spec, axis, parameters[:, axis]) for axis in range(3)]
    columns, values = np.zeros((len(vertices), 1), int), np.ones((len(vertices), 1))
    for axis, (index, weight) in enumerate(taps):
        columns = (columns[:, :, None] * spec.shape[axis] + index[:, None, :]).reshape(len(vertices), -1)
        values = (values[:, :, None] * weight[:, None, :]).reshape(len(vertices), -1)
    rows = np.arange(0, values.size + 1, values.shape[1])
    return sparse.csr_matrix((values.ravel(), columns.ravel(), rows), shape=(len(vertices), int(np.prod(spec.shape))))


def sparse_axis(spec: Spec, axis: int, t: NDArray) -> tuple[NDArray, NDArray]:
    """(V, d + 1) indices and values of the basis functions that are not zero at t."""
    degree, count = spec.axis_degree(axis), spec.shape[axis]
    knots = spec.knot_vector(axis)
    first = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, count - 1) - degree
    index = first[:, None] + np.arange(degree + 1)
    return index, np.take_along_axis(spec.axis_weights(axis, t), index, axis=1)


def bumpy_sphere(rings: int) -> meshes.Mesh:
    """Closed latitude-longitude sphere with fine bumps, of 2 rings² − 2 rings + 2 vertices, inside the unit cube."""
    around = 2 * rings
    theta, phi = np.meshgrid(np.arange(1, rings) * np.pi / rings, np.arange(around) * np.pi / rings, indexing="ij")
    bumps = 1 + 0.02 * np.sin(40 * theta) * np.sin(40 * phi) * np.sin(theta) ** 2
    ring = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    points = np.concatenate([(bumps[..., None] * ring).reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]]) * 0.45 + 0.5
    i, j = (index.ravel() for index in np.meshgrid(np.arange(rings - 2), np.arange(around), indexing="ij"))
    here, beside = i * around + j, i * around + (j + 1) % around
    below, both = here + around, beside + around
    turn, north = np.arange(around), len(points) - 2
    ahead, last = (turn + 1) % around, (rings - 2) * around
    cap = [
        np.stack([np.full(around, north), turn, ahead], 1),
        np.stack([last + ahead, last + turn, turn * 0 + north + 1], 1),
    ]
    sides = [np.stack([here, below, both], 1), np.stack([here, both, beside], 1)]
    return points, np.concatenate([*sides, *cap]).astype(np.int32)


def medians(calls: list[Callable[[], object]], repeats: int) -> list[float]:
    """Median seconds per call; they take turns, so that a busy machine slows all alike; first turns do not count."""
    took: list[list[float]] = [[] for _ in calls]
    for turn in range(repeats + 1):
        for call, seconds in zip(calls, took):
            start = time.perf_counter()
            call()
            if turn:
                seconds.append(time.perf_counter() - start)
    return [median(seconds) for seconds in took]


def report_times(rings: int, repeats: int) -> bool:
    """Prints the table of times; True if the target is met and both formulations give the same δ."""
    vertices, triangles = bumpy_sphere(rings)
    control = lattices.deformed(UNIFORM, "squash", 0.5) + 0.02 * np.sin(7 * UNIFORM.rest[..., ::-1])
    print(
        f"{len(vertices):,} vertices, {len(triangles):,} triangles; uniform cubic lattice of 10³; medians of {repeats}"
    )
    start = time.perf_counter()
    paper = Paper.of(UNIFORM, vertices, triangles)
    print(f"paper's matrices built beforehand in {time.perf_counter() - start:.1f} s, not timed: ", end="")
    print(f"N×F with {paper.faces.nnz:,} numbers, V×N with {paper.weights.nnz:,}\n")
    flat = control.reshape(-1, 3)
    reference = paper.volume(vertices)
    bindings = [
        UNIFORM.build().bind(vertices.astype(dtype), triangles, device="cpu") for dtype in (np.float64, np.float32)
    ]
    ours = [partial(binding.preserve, control, method="sweep") for binding in bindings]
    baseline, *preserve = medians([lambda: paper.sweep(flat, reference), *ours], repeats)
    print(f"{'':36}{'float64':>12}{'float32':>12}   (ms)")
    print(f"{'paper: sweep, x y z, and FFD':36}{baseline * MILLI:12.1f}")
    rows = {"preserve, sweep, x y z": preserve} | other_times(bindings, vertices, triangles, control, repeats)
    for name, times in rows.items():
        print(f"{'isochor: ' + name:36}" + "".join(f"{seconds * MILLI:12.2f}" for seconds in times))
    ratios = [seconds / baseline for seconds in preserve]
    judged = len(vertices) >= JUDGED_FROM
    met = all(ratio <= RATIO_TARGET for ratio in ratios) or not judged
    print(f"{'preserve ÷ paper':36}" + "".join(f"{ratio:12.4f}" for ratio in ratios), end="")
    verdict = ("met" if met else "MISSED") if judged else f"for {JUDGED_FROM:,} vertices and more, not judged here"
    print(f"   target ≤ {RATIO_TARGET:g}: {verdict}")
    expected = paper.sweep(flat, reference)[0] - flat
    agree = True
    for binding, name, room in zip(bindings, ("float64", "float32"), (1e-9, 1e-4)):
        found = binding.preserve(control, method="sweep").control.reshape(-1, 3) - flat
        difference = float(np.linalg.norm(found - expected) / np.linalg.norm(expected))
        agree &= difference <= room
        print(f"δ against the paper's, {name}: {difference:.1e} of its length (room {room:g})")
    return met and agree


def other_times(bindings, vertices, triangles, control, repeats: int) -> dict[str, list[float]]:
    """Median seconds of every other call, float64 and float32."""
    lattice = UNIFORM.build()
    arrays = [vertices.astype(dtype) for dtype in (np.float64, np.float32)]
    pairs = list(zip(bindings, arrays))
    calls: dict[str, Callable] = {
        "preserve, balanced, x y z": lambda binding, _: binding.preserve(control),
        "preserve, balanced, x y": lambda binding, _: binding.preserve(control, axes=(1, 1, 0)),
        "deform": lambda binding, _: binding.deform(control),
        "volume": lambda binding, _: binding.volume(control),
        "bind": lambda _, array: lattice.bind(array, triangles, device="cpu"),
        "update": lambda binding, array: binding.update(array),
    }
    return {name: medians([partial(call, *pair) for pair in pairs], repeats) for name, call in calls.items()}


def report_errors(level: int) -> bool:
    """Prints the largest relative volume error for each method, basis and shares, over losses and gains."""
    specs = {
        "Bernstein 4³": Spec((4, 4, 4)),
        "cubic 6³ uniform": Spec((6, 6, 6), "bspline", 3, "uniform"),
        "cubic 6³ clamped": Spec((6, 6, 6), "bspline", 3, "clamped"),
        "cubic 10³ uniform": UNIFORM,
        "cubic 10³ clamped": Spec((10, 10, 10), "bspline", 3, "clamped"),
    }
    cases = [
        ("squash", 0.28),
        ("squash", 0.64),
        ("squash", 0.85),
        ("wobble", 0.8),
        ("spread", 1.0),
        ("inflate", 0.5874),
    ]
    names = ", ".join(f"{kind} {strength:g}" for kind, strength in cases)
    print(f"\nworst relative volume error (and what 4 ε A R / |V| allows there), over {names}")
    print(f"{'method':10}{'lattice':20}{'shares':10}{'float64':>22}{'float32':>22}")
    good = True
    for method in ("sweep", "balanced"):
        for name, spec in specs.items():
            for shares in ((1, 1, 1), (1, 1, 0), (0, 0, 1)):
                cells = [worst_error(spec, method, shares, cases, level, dtype) for dtype in (np.float64, np.float32)]
                print(f"{method:10}{name:20}{''.join(map(str, shares)):10}", end="")
                print("".join(f"{error:11.1e} ({room:7.1e})" for error, room, _ in cells))
                good &= all(met for *_, met in cells)
    print("every error within max(1e-12 or 1e-6, 4 ε A R / |V|): " + ("yes" if good else "NO"))
    return good


def worst_error(spec: Spec, method: str, shares, cases, level: int, dtype) -> tuple[float, float, bool]:
    """Largest relative error over `cases`, 4 ε A R / |V| of that case, and whether all were within tolerance."""
    vertices, triangles = meshes.bumpy_ball(level, 0.15)
    vertices = vertices.astype(dtype)
    binding = spec.build().bind(vertices, triangles, device="cpu")
    target, found = oracle.volume(vertices, triangles, spec.centre), []
    for kind, strength in cases:
        out = binding.preserve(lattices.deformed(spec, kind, strength), axes=shares, method=method).vertices
        error = abs(oracle.volume(out, triangles, spec.centre) - target) / abs(target)
        reach = float(np.abs(out.astype(float) - spec.centre).max())
        room = 4 * float(np.finfo(dtype).eps) * oracle.area(out, triangles) * reach / abs(target)
        found.append((error, room, error <= oracle.tolerance(out, triangles, spec.centre, target)))
    error, room, _ = max(found)
    return error, room, all(met for *_, met in found)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--quick", action="store_true", help="a smaller mesh and fewer repeats: a smoke test")
    parser.add_argument("--repeats", type=int, default=None, help="timed runs of each call (default 9, quick 3)")
    options = parser.parse_args()
    repeats = options.repeats or (3 if options.quick else 9)
    device = isochor.devices()[-1]
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}; {device.name}")
    fast = report_times(70 if options.quick else 470, repeats)
    exact = report_errors(2 if options.quick else 4)
    return 0 if fast and exact else 1


if __name__ == "__main__":
    sys.exit(main())
