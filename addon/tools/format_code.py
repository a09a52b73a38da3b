# SPDX-License-Identifier: GPL-3.0-or-later
"""Formats the Rust and Python code and applies ruff's safe fixes. Use: python format_code.py."""

import environments
import toolchain
from legs import PYTHON_CODE
from workspace import as_program, run


def main() -> None:
    run([toolchain.cargo(), "fmt", "--all"])
    ruff = environments.python("tools").with_name("ruff")
    run([ruff, "check", "--fix", *PYTHON_CODE])
    run([ruff, "format", *PYTHON_CODE])


if __name__ == "__main__":
    as_program(main)
