# SPDX-License-Identifier: GPL-3.0-or-later
"""Which device computes: by word, by name, by measured cost; changed mid-session; several at once."""

import os
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import isochor
import lattices
import meshes
import numpy as np
import pytest
from oracle import Spec

SPEC = Spec((6, 6, 6), "bspline", 3, "uniform")
MESH = meshes.bumpy_ball(4, 0.15)
SINGLE = MESH[0].astype(np.float32), MESH[1]
CONTROL = lattices.deformed(SPEC, "squash", 0.5)


def test_adapters_are_listed_with_their_kind_and_the_cpu_comes_last():
    found = isochor.devices()
    assert found[-1].kind == "cpu"
    assert {device.kind for device in found[:-1]} <= {"gpu", "software"}
    assert {device.backend for device in found[:-1]} <= {"vulkan", "metal", "dx12"}
    assert [device.kind for device in found] == sorted(
        (device.kind for device in found), key=["gpu", "software", "cpu"].index
    )


def test_an_adapter_by_its_name(adapter):
    binding = SPEC.build().bind(*SINGLE, device=adapter.name)
    assert (binding.device, binding.device_name) == ("gpu", adapter.name)
    assert binding.preserve(CONTROL).device == "gpu"
    assert binding.device_name == adapter.name


def test_gpu_takes_what_is_best(adapter):
    binding = SPEC.build().bind(*SINGLE, device="gpu")
    assert (binding.device, binding.device_name) == ("gpu", adapter.name)
    assert "gpu" in repr(binding)


def test_an_unknown_name_lists_what_there_is():
    with pytest.raises(isochor.UnknownDeviceError, match=r"Voodoo.*auto.*cpu.*gpu.*devices"):
        SPEC.build().bind(*SINGLE, device="Voodoo 2")


def test_auto_never_takes_a_software_rasteriser(adapter):
    binding = SPEC.build().bind(*(part for part in single(7)))
    ran = [binding.preserve(CONTROL).device for _ in range(4)]
    if adapter.kind == "software":
        assert ran == ["cpu"] * 4
        assert binding.device == "cpu"
        assert binding.device_name.startswith("CPU")
    else:
        assert ran[:3] == ["cpu", "gpu", "gpu"]


def single(level: int):
    vertices, triangles = meshes.icosphere(level)
    return vertices.astype(np.float32), triangles


def test_auto_measures_both_and_stays_with_the_faster():
    """In a process where the software rasteriser passes for a card: timed on the CPU, warmed up, timed, decided."""
    program = """
        import isochor, numpy as np
        from test_devices import CONTROL, SPEC, single
        small = SPEC.build().bind(*single(4))
        assert [small.preserve(CONTROL).device for _ in range(4)] == ["cpu"] * 4
        binding = SPEC.build().bind(*single(6))
        ran = [binding.preserve(CONTROL) for _ in range(5)]
        devices = [result.device for result in ran]
        assert devices[:3] == ["cpu", "gpu", "gpu"], devices
        assert devices[3] == devices[4] == binding.device, devices
        assert all(result.error < 1e-6 for result in ran)
        binding.update(single(6)[0] * np.float32(0.9))
        assert binding.preserve(CONTROL).device == "cpu"
    """
    run(program, ISOCHOR_GPU_FAULT="trust")


def run(program: str, **env: str) -> str:
    """Runs Python code in a process of its own, with warnings as errors."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(program)],
        cwd=Path(__file__).parent,
        env={**os.environ, "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{Path(meshes.__file__).parent}", **env},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_device_changes_mid_session():
    results = []
    for device in ("gpu", "cpu", "gpu"):
        result = SPEC.build().bind(*SINGLE, device=device).preserve(CONTROL)
        assert result.device == device
        results.append(result.vertices)
    np.testing.assert_array_equal(results[0], results[2])
    np.testing.assert_allclose(results[0], results[1], rtol=0, atol=2e-6)


def test_updates_reach_the_gpu():
    binding = SPEC.build().bind(*SINGLE, device="gpu")
    first = binding.preserve(CONTROL).vertices
    moved = SINGLE[0] * np.float32(0.9) + np.float32(0.05)
    binding.update(moved)
    assert binding.device == "gpu"
    second = binding.preserve(CONTROL)
    assert second.device == "gpu"
    fresh = SPEC.build().bind(moved, SINGLE[1], device="gpu").preserve(CONTROL)
    np.testing.assert_array_equal(second.vertices, fresh.vertices)
    assert np.abs(second.vertices - first).max() > 1e-3


def test_the_same_bits_on_every_run():
    runs = [SPEC.build().bind(*SINGLE, device="gpu").preserve(CONTROL) for _ in range(3)]
    assert {result.device for result in runs} == {"gpu"}
    assert len({result.vertices.tobytes() + result.control.tobytes() for result in runs}) == 1


def test_two_bindings_and_one_binding_from_several_threads():
    """As when a render evaluates on its own thread while the viewport updates, with two objects in the scene."""
    bindings = [SPEC.build().bind(*SINGLE, device="gpu"), Spec((4, 4, 4)).build().bind(*single(5), device="gpu")]
    poses = [
        [lattices.deformed(spec, "squash", strength) for strength in (0.2, 0.5)] for spec in (SPEC, Spec((4, 4, 4)))
    ]
    jobs = [(which, pose) for _ in range(6) for which in (0, 1) for pose in (0, 1)]

    def frame(job):
        which, pose = job
        result = bindings[which].preserve(poses[which][pose])
        assert result.device == "gpu"
        return job, result.vertices.tobytes()

    expected = dict(map(frame, jobs[:4]))
    with ThreadPoolExecutor(4) as pool:
        for job, vertices in pool.map(frame, jobs):
            assert vertices == expected[job]


def test_device_time_is_told_where_the_gpu_keeps_time():
    gpu = SPEC.build().bind(*SINGLE, device="gpu").preserve(CONTROL)
    assert gpu.device == "gpu"
    assert gpu.device_seconds is None or 0 < gpu.device_seconds < 60
    assert SPEC.build().bind(*SINGLE, device="cpu").preserve(CONTROL).device_seconds is None


def test_points_without_triangles_deform():
    binding = SPEC.build().bind(SINGLE[0], device="gpu")
    expected = SPEC.build().bind(SINGLE[0], device="cpu").deform(CONTROL)
    np.testing.assert_allclose(binding.deform(CONTROL), expected, rtol=0, atol=1e-6)
    with pytest.raises(isochor.MeshError):
        binding.preserve(CONTROL)
    assert len(SPEC.build().bind(SINGLE[0][:0], device="cpu").deform(CONTROL)) == 0
