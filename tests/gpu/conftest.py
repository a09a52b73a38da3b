# SPDX-License-Identifier: GPL-3.0-or-later
"""The adapter that these tests run on: named in the header; none is a failure in CI and a loud skip elsewhere.

Meshes, lattices and the oracle are those of tests/native.
"""

import os
import sys
from pathlib import Path

import isochor
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "native"))

ADAPTERS = [device for device in isochor.devices() if device.kind != "cpu"]
IN_CI = os.environ.get("CI", "").lower() in {"1", "true", "yes"}
MISSING = "no Vulkan, Metal or DirectX 12 adapter: the GPU path is NOT TESTED; install mesa-vulkan-drivers"


def pytest_report_header() -> list[str]:
    return [f"GPU adapters: {ADAPTERS or 'NONE'}"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if ADAPTERS or IN_CI:
        return
    for item in items:
        item.add_marker(pytest.mark.skip(reason=MISSING))


@pytest.fixture(autouse=True, scope="session")
def adapter() -> isochor.Device:
    """The adapter that device="gpu" takes."""
    if not ADAPTERS:
        pytest.fail(MISSING)
    return ADAPTERS[0]
