# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a GPU is missing or fails, the CPU takes over in the same call, with one warning and the same picture.

Each case in a process of its own: what it breaks is the process's.
"""

import pytest
from test_devices import run

PROGRAM = """
    import warnings

    import isochor
    import numpy as np
    from test_devices import CONTROL, SINGLE, SPEC

    expected = SPEC.build().bind(*SINGLE, device="cpu").preserve(CONTROL)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        binding = SPEC.build().bind(*SINGLE, device="gpu")
        results = [binding.preserve(CONTROL) for _ in range(3)]
        deformed = binding.deform(CONTROL)
        binding.update(SINGLE[0])
        results.append(binding.preserve(CONTROL))
    for result in results:
        assert result.device == "cpu", result
        np.testing.assert_array_equal(result.vertices, expected.vertices)
    assert binding.device == "cpu"
    assert binding.device_name.startswith("CPU")
    assert [item.category for item in caught] == [RuntimeWarning], caught
    print(caught[0].message)
"""


def test_no_adapter(tmp_path):
    message = run(PROGRAM, VK_DRIVER_FILES=str(tmp_path / "none.json"), VK_ICD_FILENAMES=str(tmp_path / "none.json"))
    assert "found none" in message
    assert "the CPU computes instead" in message


def test_no_vulkan_loader(tmp_path):
    (tmp_path / "libvulkan.so.1").write_bytes(b"no library at all")
    message = run(PROGRAM, LD_LIBRARY_PATH=str(tmp_path))
    assert "found none" in message


def test_a_lost_device():
    message = run(PROGRAM, ISOCHOR_GPU_FAULT="lost")
    assert "given back" in message or "lost" in message


def test_out_of_memory():
    assert "out of memory" in run(PROGRAM, ISOCHOR_GPU_FAULT="memory")


def test_a_mesh_larger_than_the_limits():
    message = run(PROGRAM, ISOCHOR_GPU_BUFFER_LIMIT="4096")
    assert "expected at most the 4096" in message


def test_a_device_lost_between_two_frames():
    """After good frames on the GPU: the picture goes on, to the tolerance, from the CPU."""
    program = """
        import os
        import warnings

        import numpy as np
        from test_devices import CONTROL, SINGLE, SPEC

        binding = SPEC.build().bind(*SINGLE, device="gpu")
        before = binding.preserve(CONTROL)
        assert before.device == "gpu"
        os.environ["ISOCHOR_GPU_FAULT"] = "lost"
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            after = [binding.preserve(CONTROL) for _ in range(3)]
        del os.environ["ISOCHOR_GPU_FAULT"]
        assert [result.device for result in after] == ["cpu"] * 3
        assert len(caught) == 1
        assert np.abs(after[0].vertices - before.vertices).max() < 2e-6
        again = SPEC.build().bind(*SINGLE, device="gpu").preserve(CONTROL)
        assert again.device == "gpu", "a new binding opens the device anew"
        np.testing.assert_array_equal(again.vertices, before.vertices)
    """
    run(program)


def test_a_missing_card_is_no_matter_to_auto(tmp_path):
    program = """
        from test_devices import CONTROL, SPEC, single
        binding = SPEC.build().bind(*single(6))
        assert [binding.preserve(CONTROL).device for _ in range(3)] == ["cpu"] * 3
    """
    run(program, VK_DRIVER_FILES=str(tmp_path / "none.json"), VK_ICD_FILENAMES=str(tmp_path / "none.json"))


@pytest.mark.parametrize("name", ["ISOCHOR_GPU_FAULT", "ISOCHOR_GPU_BUFFER_LIMIT"])
def test_the_cpu_asked_for_never_looks_at_a_gpu(name):
    program = """
        from test_devices import CONTROL, SINGLE, SPEC
        assert SPEC.build().bind(*SINGLE, device="cpu").preserve(CONTROL).device == "cpu"
    """
    run(program, **{name: "lost" if "FAULT" in name else "1"})
