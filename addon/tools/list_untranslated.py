# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists the texts of the extension that a language lacks, and those that it has without need. Needs no Blender.

Use: python list_untranslated.py. Ends with status 1 where something is missing. A text is found where it stands as a
constant: as label or docstring of a Blender class, as name, description or item of a property, as text= of a layout,
in report() and poll_message_set(), in Problem(), Sentence(), words.shown() and words.reported(), also where these are
given a constant of the module by its name, and anywhere in SPOKEN, TOOLTIPS and INTERFACE. Text with names in it that
is no Sentence stays English in every language: it is listed last. The command line speaks English.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "isochor"
LANGUAGES = SOURCE / "languages"
LABELS = {"bl_label", "bl_description"}
KEYWORDS = {"name", "description", "text", "text_ctxt", "heading", "title", "message", "confirm_text"}
PLACED = ("label", "prop", "operator", "menu", "invoke_confirm", "invoke_props_dialog", "update")
WRITERS = {"report", "poll_message_set", "Problem", "Refused", "Sentence", "sentence", "shown", "reported"}
SPOKEN = SOURCE / "core" / "problem.py"
"""Every string in it is the user's to read."""
TOOLTIPS = SOURCE / "tool" / "group_inputs.py"
INTERFACE = SOURCE / "ui"
"""All prose of the one is tooltips of the modifier's inputs, all of the other is shown."""
ENGLISH = (SOURCE / "core" / "frame_range.py", SOURCE / "core" / "joining.py")
"""Used by the command line alone."""
PROSE = re.compile(r"[^\W\d_]{2,} [^\W\d_]{2,}")
"""Two words in a row, by which a sentence is known from an expression or a name."""


def main() -> int:
    missing = 0
    for language in languages():
        lacking, needless = compare(language)
        missing += len(lacking)
        print(f"{language}: {len(lacking)} missing, {len(needless)} no longer in the code")
        for mark, texts in (("+", lacking), ("-", needless)):
            for text in texts:
                print(f"  {mark} {text!r}")
    stuck = [line for place in sources() for line in untranslatable(place)]
    print(f"{len(stuck)} made without a Sentence, so English in every language")
    for line in stuck:
        print(f"  ! {line}")
    return 1 if missing else 0


def languages() -> list[str]:
    """Names of the language modules."""
    return sorted(place.stem for place in LANGUAGES.glob("*.py") if place.stem != "__init__")


def catalogue(language: str) -> dict[str, str]:
    """The texts of one language, English to its own."""
    for node in ast.parse((LANGUAGES / f"{language}.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "TEXTS":
            texts: dict[str, str] = ast.literal_eval(node.value)
            return texts
    raise SystemExit(f"{language}.py has no dictionary TEXTS")


def compare(language: str) -> tuple[list[str], list[str]]:
    """What the code says and the language does not, and the other way round."""
    used, known = used_texts(), set(catalogue(language))
    return sorted(used - known), sorted(known - used)


def used_texts() -> set[str]:
    """Every English text that the extension shows."""
    found = {text for place in sources() for text in texts_of(place)}
    return {text for text in found if any(letter.isalpha() for letter in re.sub(r"{\w*}", "", text))}


def sources() -> list[Path]:
    """The extension's modules but for its languages and its command line."""
    found = [place for place in SOURCE.rglob("*.py") if LANGUAGES not in place.parents]
    return sorted(place for place in found if place not in ENGLISH and not place.name.startswith("command_"))


def untranslatable(place: Path) -> Iterator[str]:
    """Where a file shows a formatted string, which cannot be looked up, or makes one that reads like a sentence. Where
    its words are names alone, or those of an exception for programmers, no matter."""
    tree = ast.parse(place.read_text(encoding="utf-8"))
    shown, raised = set(written(tree)), set(for_programmers(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and node not in raised:
            words = "…".join(text for part in node.values for text in constants(part))
            if PROSE.search(words) or (node in shown and any(letter.isalpha() for letter in words)):
                yield f"{place.relative_to(SOURCE)}:{node.lineno} {ast.unparse(node)}"


def called(node: ast.AST | None) -> str:
    """The last name of what is called; empty where nothing is."""
    return ast.unparse(node.func).rpartition(".")[2] if isinstance(node, ast.Call) else ""


def written(tree: ast.Module) -> Iterator[ast.expr]:
    """What is handed to a writer or a label."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and called(node) in {*WRITERS, "label"}:
            yield from node.args
            yield from (keyword.value for keyword in node.keywords if keyword.arg == "text")


def for_programmers(tree: ast.Module) -> Iterator[ast.AST]:
    """What is inside of exceptions that are no Problem."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None and called(node.exc) not in WRITERS:
            yield from ast.walk(node.exc)


def texts_of(place: Path) -> Iterator[str]:
    """The texts that one file shows."""
    tree = ast.parse(place.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield from of_class(node)
        elif isinstance(node, ast.Call):
            yield from of_call(node)
        elif isinstance(node, ast.Tuple):
            yield from of_item(node.elts)
    yield from of_names(tree)
    if place == SPOKEN:
        yield from spoken(tree)
    elif place == TOOLTIPS or INTERFACE in place.parents:
        yield from prose(tree)


def of_names(tree: ast.Module) -> Iterator[str]:
    """Constants of the module that are handed to a writer by name."""
    names = {node.id for argument in written(tree) for node in ast.walk(argument) if isinstance(node, ast.Name)}
    for line in tree.body:
        if isinstance(line, ast.Assign) and ast.unparse(line.targets[0]) in names:
            yield from constants(line.value)


def of_class(node: ast.ClassDef) -> Iterator[str]:
    """Label and docstring of a class that Blender shows."""
    if not any(ast.unparse(base).startswith("bpy.types.") for base in node.bases):
        return
    doc = ast.get_docstring(node)
    if doc:
        yield " ".join(doc.split())
    for line in node.body:
        if isinstance(line, ast.Assign) and ast.unparse(line.targets[0]) in LABELS:
            yield from constants(line.value)


def of_call(node: ast.Call) -> Iterator[str]:
    """Texts handed to a property, a layout, a report."""
    name = called(node)
    if name.endswith("Property") or "layout" in ast.unparse(node.func) or name in PLACED:
        for keyword in node.keywords:
            if keyword.arg in KEYWORDS:
                yield from constants(keyword.value)
    if name in WRITERS:
        for argument in node.args:
            if not isinstance(argument, ast.Call):
                yield from constants(argument)
    if name[:1].isupper():
        yield from of_item(node.args)


def of_item(parts: list[ast.expr]) -> Iterator[str]:
    """Name and description of an item of an enumeration, a tuple or a call: (IDENTIFIER, "Name", "Description", …)."""
    if len(parts) < 3:
        return
    identifier, *texts = parts[:3]
    named = isinstance(identifier, (ast.Name, ast.Attribute)) or any(text.isupper() for text in constants(identifier))
    strings = [text.value for text in texts if isinstance(text, ast.Constant) and isinstance(text.value, str)]
    if named and len(strings) == len(texts) and not strings[-1].isupper():
        for text in texts:
            yield from constants(text)


def spoken(tree: ast.Module) -> Iterator[str]:
    """Constants that a module assigns or returns."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.Assign, ast.Return)) and node.value is not None:
            yield from constants(node.value)


def prose(tree: ast.Module) -> Iterator[str]:
    """Strings of several words of which not each has a capital, as names have; no docstrings, no formatted strings."""
    silent = {
        child
        for node in ast.walk(tree)
        if isinstance(node, (ast.Expr, ast.JoinedStr))
        for child in (ast.walk(node) if isinstance(node, ast.JoinedStr) else [node.value])
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node not in silent and re.search(" [a-z]", str(node.value)):
            yield str(node.value)


def constants(node: ast.expr) -> Iterator[str]:
    """The string that an expression is, or the two that it chooses from."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from constants(node.body)
        yield from constants(node.orelse)


if __name__ == "__main__":
    sys.exit(main())
