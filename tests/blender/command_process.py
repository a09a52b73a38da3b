# SPDX-License-Identifier: GPL-3.0-or-later
"""What `blender --command isochor …` does, in a bpy process: enables the installed extension and hands it the words."""

import importlib
import sys

import bpy
from installed_extension import MODULE, leave

if __name__ == "__main__":
    bpy.ops.preferences.addon_enable(module=MODULE)
    leave(importlib.import_module(f"{MODULE}.tool.command_line").run(sys.argv[1:]))
