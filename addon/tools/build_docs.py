# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the reference of the Python module, from the docstrings of the installed wheel, into out/docs/python, and that
of the Rust crates into out/docs/rust.

Use: python build_docs.py [python] [rust]; without a name, both.
"""

import shutil
import sys
from pathlib import Path

import build_wheel
import environments
import toolchain
from workspace import OUT, ROOT, Command, as_program, fail, run, say

PLACE = OUT / "docs"
LOOK = Path(__file__).with_name("docs_look")
CRATES = ("isochor-core", "isochor-gpu")


def python_reference() -> None:
    """HTML of the module isochor, by pdoc."""
    interpreter = environments.install_wheel("docs", build_wheel.wheel())
    place = PLACE / "python"
    shutil.rmtree(place, ignore_errors=True)
    # In an empty folder: the sources of the clone must not stand before the wheel.
    place.mkdir(parents=True)
    command: Command = [interpreter, "-m", "pdoc", "--docformat", "restructuredtext", "--no-show-source"]
    look: Command = ["--template-directory", LOOK, "--footer-text", "Isochor, GPL-3.0-or-later"]
    run([*command, *look, "--output-directory", place, "isochor"], cwd=place)
    page = place / "isochor.html"
    # A default that Python cannot show is "..." in the binding's signatures; pdoc writes the object's name.
    page.write_text(page.read_text(encoding="utf-8").replace("Ellipsis", "..."), encoding="utf-8")
    say(f"wrote {page}")


def rust_reference() -> None:
    """HTML of our crates, by rustdoc."""
    crates = [f"--package={crate}" for crate in CRATES]
    run([toolchain.cargo(), "doc", "--no-deps", "--locked", *crates])
    place = PLACE / "rust"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(ROOT / "target" / "doc", place)
    say(f"wrote {place / 'isochor_core' / 'index.html'}")


PARTS = {"python": python_reference, "rust": rust_reference}


def main(names: list[str]) -> None:
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        fail(f"build_docs.py: unknown name {' '.join(unknown)}, expected {' '.join(PARTS)}")
    for name in names or PARTS:
        PARTS[name]()


if __name__ == "__main__":
    as_program(lambda: main(sys.argv[1:]))
