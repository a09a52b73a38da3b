# SPDX-License-Identifier: GPL-3.0-or-later
"""Same bits on every run, with one thread or two, from several Python threads; and Python goes on meanwhile."""

import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import lattices
import meshes
import numpy as np
import pytest
from oracle import Spec

SPEC = Spec((10, 10, 10), "bspline", 3, "uniform")
MESH = meshes.bumpy_ball(6, 0.1)  # 40,962 vertices: enough to be split among threads
LARGE = meshes.icosphere(7)
CONTROL = lattices.noisy(SPEC, 0.05) * [1, 1, 0.5]

DIGEST = """
import hashlib
import lattices, meshes
import numpy as np
from test_threads import CONTROL, MESH, SPEC

digest = hashlib.sha256()
for dtype in (np.float64, np.float32):
    binding = SPEC.build().bind(MESH[0].astype(dtype), MESH[1], outside="extend")
    digest.update(np.float64([binding.reference_volume, binding.volume(CONTROL)]).tobytes())
    digest.update(binding.deform(CONTROL).tobytes())
    for method in ("sweep", "balanced"):
        result = binding.preserve(CONTROL, method=method)
        digest.update(result.control.tobytes() + result.vertices.tobytes() + np.float64(result.volume).tobytes())
    binding.update((MESH[0] * 0.9).astype(dtype))
    digest.update(binding.preserve(CONTROL).control.tobytes())
print(digest.hexdigest())
"""


def digest(script: str, threads: int) -> str:
    """What a script prints that runs in a process of its own with so many threads."""
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=Path(__file__).parent,
        env={**os.environ, "RAYON_NUM_THREADS": str(threads)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_the_same_bits_with_one_two_and_seven_threads():
    assert len({digest(DIGEST, threads) for threads in (1, 2, 7)}) == 1


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
def test_the_same_bits_on_every_run(dtype):
    bindings = [SPEC.build().bind(MESH[0].astype(dtype), MESH[1], outside="extend") for _ in range(2)]
    results = [binding.preserve(CONTROL) for binding in bindings for _ in range(3)]
    for result in results[1:]:
        np.testing.assert_array_equal(result.control, results[0].control)
        np.testing.assert_array_equal(result.vertices, results[0].vertices)


def test_one_binding_from_several_threads():
    binding = SPEC.build().bind(*MESH, outside="extend")
    controls = [lattices.noisy(SPEC, 0.05, seed) * [1, 1, 0.5] for seed in range(4)]
    expected = [(binding.deform(c), binding.volume(c), binding.preserve(c).control) for c in controls]

    def work(number: int) -> bool:
        control, (deformed, volume, corrected) = controls[number % 4], expected[number % 4]
        return (
            np.array_equal(binding.deform(control), deformed)
            and binding.volume(control) == volume
            and np.array_equal(binding.preserve(control).control, corrected)
        )

    with ThreadPoolExecutor(6) as pool:
        assert all(pool.map(work, range(24)))


def test_update_while_others_read_is_before_or_after_never_between():
    small = meshes.bumpy_ball(4, 0.1)
    states = [small[0], small[0] * 0.8]
    binding = SPEC.build().bind(small[0], small[1], outside="extend")
    possible = []
    for state in states:
        binding.update(state)
        possible.append(binding.deform(CONTROL))
    stop = threading.Event()

    def flip() -> int:
        flips = 0
        while not stop.is_set():
            binding.update(states[flips % 2])
            flips += 1
        return flips

    with ThreadPoolExecutor(3) as pool:
        flipping = pool.submit(flip)
        try:
            for _ in range(100):
                out = binding.deform(CONTROL)
                assert any(np.array_equal(out, state) for state in possible)
        finally:
            stop.set()
        assert flipping.result() > 0


def copies(vertices, triangles, count: int):
    """`count` balls in one place: a mesh large enough that what a call does under the lock is small beside it."""
    offsets = np.arange(count)[:, None, None] * len(vertices)
    return np.tile(vertices, (count, 1)), (triangles + offsets).reshape(-1, 3)


def longest_silence(call) -> tuple[float, float]:
    """Seconds that `call` takes in another thread, and the longest that this thread could not run meanwhile."""
    started, done = threading.Event(), threading.Event()
    took = []

    def run() -> None:
        started.set()
        start = time.perf_counter()
        call()
        took.append(time.perf_counter() - start)
        done.set()

    thread = threading.Thread(target=run)
    thread.start()
    started.wait()
    longest, last = 0.0, time.perf_counter()
    while not done.is_set():
        time.sleep(0.0005)
        now = time.perf_counter()
        longest, last = max(longest, now - last), now
    thread.join()
    return took[0], longest


@pytest.mark.parametrize("call", ["bind", "update", "deform", "volume", "preserve"])
def test_python_runs_on_while_the_library_computes(call):
    """No call holds the interpreter lock: the longest silence of another thread is much shorter than the call."""
    vertices, triangles = copies(*LARGE, 6)
    lattice = SPEC.build()
    binding = lattice.bind(vertices, triangles)
    control = np.ascontiguousarray(SPEC.rest * [1, 1, 0.5])
    calls = {
        "bind": lambda: lattice.bind(vertices, triangles),
        "update": lambda: binding.update(vertices),
        "deform": lambda: binding.deform(control),
        "volume": lambda: binding.volume(control),
        "preserve": lambda: binding.preserve(control),
    }
    shares = []
    for _ in range(8):
        took, silence = longest_silence(calls[call])
        shares.append(silence / took)
    assert min(shares) < 0.5, f"silent for {min(shares):.0%} of the call at best"
