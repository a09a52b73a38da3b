# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets the tests import the tools as they import each other."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon" / "tools"))
