# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the templates under test are."""

from pathlib import Path

FARM = Path(__file__).resolve().parents[2] / "addon" / "farm"
