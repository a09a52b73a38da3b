# SPDX-License-Identifier: GPL-3.0-or-later
"""The laws of free-form deformation on the GPU: the table of tests/native."""

import laws_of_blender  # noqa: F401 — each puts its laws into the table
import laws_of_chains  # noqa: F401
import laws_of_joints  # noqa: F401
import laws_of_papers  # noqa: F401
import laws_of_planes  # noqa: F401
import laws_of_surfaces  # noqa: F401
import laws_of_weights  # noqa: F401
import laws_on_devices  # noqa: F401
import numpy as np
import pytest
from laws_deforming import TABLE, Run


@pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["float64", "float32"])
@pytest.mark.parametrize(("law", "case"), TABLE)
def test_law(law, case, dtype):
    law(Run("gpu", dtype), case)
