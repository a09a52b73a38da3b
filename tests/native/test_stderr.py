# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input in a process of its own: it must end well and leave nothing on stderr, neither panic nor trace."""

import os
import subprocess
import sys
import textwrap

PROGRAM = """
    import itertools
    import numpy as np
    import isochor

    nan, inf = float("nan"), float("inf")
    odd = [None, "text", b"bytes", 0, -1, 1.5, nan, inf, 2**80, (), (1,), (1, 2, 3), (nan,) * 3, {}, object(), 1j, True,
           np.zeros((0, 3)), np.zeros((3, 3)), np.full((3, 3), nan), np.ones((2, 3), np.float16), np.ones((1, 3), bool),
           np.ones((2, 3), complex), np.array("x"), np.array([None]), np.zeros((4, 4, 4, 3)), np.full((4, 4, 4), inf),
           np.full((4, 4, 4), nan), np.full((4, 4, 4, 3), 1e308), np.array([[0, 1, 2**62]]), np.array([[-1, 0, 1]]),
           np.zeros((2, 3), [("a", float)]), np.zeros((2, 3), "M8[s]")]
    points = np.random.default_rng(0).random((30, 3))
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    lattice = isochor.Lattice(shape=(4, 4, 4))
    binding = lattice.bind(points[:4], tetrahedron)
    calls = 0

    def tried(call, *arguments, **options):
        global calls
        calls += 1
        try:
            call(*arguments, **options)
        except isochor.Error as error:
            assert isinstance(error, (ValueError, RuntimeError)), error
            assert len(str(error)) > 15, error

    for value in odd:
        for name in ("shape", "basis", "degree", "knots", "origin", "edges", "weights"):
            options = {"shape": (6, 6, 6), "basis": "bspline", "degree": 3, name: value}
            tried(isochor.Lattice, **options)
        tried(isochor.Lattice.around, value, shape=(4, 4, 4))
        tried(isochor.Lattice.around, points, shape=(4, 4, 4), margin=value)
        tried(lattice.parameters, value)
        tried(lattice.evaluate, value, lattice.rest)
        tried(lattice.evaluate, points, value)
        tried(lattice.bind, value)
        for name in ("triangles", "device", "outside", "influence"):
            tried(lattice.bind, points, **{name: value})
        tried(binding.update, value)
        tried(binding.deform, value)
        tried(binding.volume, value)
        tried(binding.preserve, value)
        for name in ("axes", "frame", "method", "weights", "pins", "target", "amount"):
            tried(binding.preserve, lattice.rest, **{name: value})
    for first, second in itertools.product(odd, repeat=2):
        tried(lattice.bind, first, second)
    print("calls", calls)
"""


def test_no_panic_text_and_no_trace_reaches_stderr():
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-W", "error", "-c", textwrap.dedent(PROGRAM)],
        # Mesa's device selection, which an unknown device's name wakes, prints where there is no desktop session.
        env={**os.environ, "NODEVICE_SELECT": "1"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.stderr == ""
    assert done.returncode == 0
    assert int(done.stdout.split()[-1]) > 1000
