# SPDX-License-Identifier: GPL-3.0-or-later
"""What the documentation names is there: pages, headings, pictures, make targets, files, operators, inputs."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from workspace import ROOT

ADDON = ROOT / "addon" / "isochor"
GUIDE = [ROOT / "docs" / "guide.md", *sorted((ROOT / "docs" / "guide").glob("*.md"))]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "addon" / "farm" / "README.md"]
EACH, ALL = 250_000, 5_000_000
"""Bytes that pictures may take."""

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
MAKE = re.compile(r"(?:`|^\$? *)make ([a-z][\w-]*)", re.MULTILINE)
OPERATOR = re.compile(r"(?:bpy\.ops\.|`)isochor\.([a-z_]+)")
FILE = re.compile(r"`([\w/.-]+\.(?:py|rs|wgsl|md|yml|toml))[`:]")


def named(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def anchors(page: Path) -> set[str]:
    """As GitHub makes them from headings."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in HEADING.findall(text)}


def local_links(page: Path) -> Iterator[str]:
    return (link for link in LINK.findall(page.read_text(encoding="utf-8")) if "://" not in link)


@cache
def sources() -> list[str]:
    """Paths of all files of the clone but those that the build makes."""
    tops = [top for top in ROOT.iterdir() if top.name not in (".git", ".build", "dist", "out", "target")]
    files = [file for top in tops for file in (top.rglob("*") if top.is_dir() else [top]) if file.is_file()]
    return [f"/{file.relative_to(ROOT).as_posix()}" for file in files]


def operators() -> set[str]:
    """Names of all operators of the add-on."""
    sources = [place.read_text(encoding="utf-8") for place in (ADDON / "ui").glob("*.py")]
    return {name for source in sources for name in re.findall(r'bl_idname = "isochor\.(\w+)"', source)}


def inputs() -> set[str]:
    """Names of the inputs that the modifier shows, from the calls that make them."""
    constants: dict[str, str] = {}
    for statement in ast.parse((ADDON / "tool" / "sockets.py").read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.Assign):
            target, value = statement.targets[0], statement.value
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            values = value.elts if isinstance(value, ast.Tuple) else [value]
            pairs = zip(names, values) if len(names) == len(values) else ()
            constants |= {n.id: v.value for n, v in pairs if isinstance(n, ast.Name) and isinstance(v, ast.Constant)}
    found = set()
    for call in ast.walk(ast.parse((ADDON / "tool" / "group_inputs.py").read_text(encoding="utf-8"))):
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") in ("_input", "_factor", "_menu", "_angle"):
            name = call.args[1]
            if isinstance(name, ast.Constant):
                found.add(name.value)
            elif isinstance(name, ast.Attribute):
                found.add(constants[name.attr])
    return found


def table_of_inputs() -> set[str]:
    """Names in the first column of the guide's table of inputs."""
    section = GUIDE[0].read_text(encoding="utf-8").split("## All inputs of the modifier")[1].split("\n## ")[0]
    rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("|")][2:]
    return {name.strip() for row in rows for name in row.split(",")}


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_link_leads_to_a_file_and_a_heading(page):
    for link in local_links(page):
        place, _, anchor = link.partition("#")
        target = (page.parent / place).resolve() if place else page
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_make_target_is_one(page):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z][\w-]*):", makefile, re.MULTILINE))
    assert set(MAKE.findall(page.read_text(encoding="utf-8"))) <= targets


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_file_that_is_named_is_there(page):
    files = sources()
    missing = {
        name
        for name in FILE.findall(page.read_text(encoding="utf-8"))
        if not any(file.endswith(f"/{name}") for file in files)
    }
    assert missing == set()


def test_every_operator_of_the_guide_is_one_and_none_is_left_out():
    written = {name for page in GUIDE for name in OPERATOR.findall(page.read_text(encoding="utf-8"))}
    assert written == operators()


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_operator_that_is_named_is_one(page):
    assert set(OPERATOR.findall(page.read_text(encoding="utf-8"))) <= operators()


def test_the_guides_table_has_the_modifiers_inputs():
    assert table_of_inputs() == inputs()


def test_every_guide_page_is_listed_in_the_guide():
    listed = {(GUIDE[0].parent / link.partition("#")[0]).resolve() for link in local_links(GUIDE[0])}
    assert set(GUIDE[1:]) <= listed


def test_pictures_are_small_and_each_is_shown():
    pictures = sorted((ROOT / "docs" / "pictures").iterdir())
    sizes = [picture.stat().st_size for picture in pictures]
    assert pictures
    assert max(sizes) <= EACH
    assert sum(sizes) <= ALL
    shown = {(page.parent / link).resolve() for page in PAGES for link in local_links(page)}
    assert set(pictures) <= shown
