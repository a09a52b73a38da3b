# SPDX-License-Identifier: GPL-3.0-or-later
"""Every test starts in an empty file with the installed extension on."""

import bpy
import pytest
import scenes
from installed_extension import MODULE


@pytest.fixture(autouse=True)
def _empty_file():
    assert MODULE in bpy.context.preferences.addons, "run these tests with run_in_blender.py, which installs the zip"
    scenes.empty_file()
