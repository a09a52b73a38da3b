# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists the texts of the extension that a language lacks, and those that it has without need. Needs no Blender.

Use: python list_untranslated.py. Ends with status 1 where something is missing. A text is found where it stands as a
constant: as label or docstring of a Blender class, as name, description or item of a property, as text= of a layout,
in report() and poll_message_set(), in Problem(), Sentence(), words.shown() and words.reported(), and anywhere in
core/problem.py. Text with names in it that is no Sentence stays English in every language: it is listed last. The
command line speaks English.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1] / "isochor"
LANGUAGES = SOURCE / "languages"
LABELS = {"bl_label", "bl_description"}
KEYWORDS = {"name", "description", "text", "text_ctxt"}
WRITERS = {"report", "poll_message_set", "Problem", "Sentence", "shown", "reported"}
SPOKEN = SOURCE / "core" / "problem.py"
"""Every string in it is the user's to read."""


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
    return {text for text in found if any(letter.isalpha() for letter in text)}


def sources() -> list[Path]:
    """The extension's modules but for its languages and its command line."""
    found = [place for place in SOURCE.rglob("*.py") if LANGUAGES not in place.parents]
    return sorted(place for place in found if not place.name.startswith("command_"))


def untranslatable(place: Path) -> Iterator[str]:
    """Where a file shows a formatted string, which cannot be looked up; where its words are names alone, no matter."""
    for node in ast.walk(ast.parse(place.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call) or ast.unparse(node.func).rpartition(".")[2] not in {*WRITERS, "label"}:
            continue
        for argument in [*node.args, *(keyword.value for keyword in node.keywords if keyword.arg == "text")]:
            if isinstance(argument, ast.JoinedStr) and has_words(argument):
                yield f"{place.relative_to(SOURCE)}:{argument.lineno} {ast.unparse(argument)}"


def has_words(formatted: ast.JoinedStr) -> bool:
    """Whether a formatted string holds letters of its own."""
    return any(letter.isalpha() for part in formatted.values for text in constants(part) for letter in text)


def texts_of(place: Path) -> Iterator[str]:
    """The texts that one file shows."""
    tree = ast.parse(place.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield from of_class(node)
        elif isinstance(node, ast.Call):
            yield from of_call(node)
        elif isinstance(node, ast.Tuple):
            yield from of_item(node)
    if place == SPOKEN:
        yield from spoken(tree)


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
    name = ast.unparse(node.func).rpartition(".")[2]
    if name.endswith("Property") or "layout" in ast.unparse(node.func) or name in ("label", "prop", "operator", "menu"):
        for keyword in node.keywords:
            if keyword.arg in KEYWORDS:
                yield from constants(keyword.value)
    if name in WRITERS:
        for argument in node.args:
            if not isinstance(argument, ast.Call):
                yield from constants(argument)


def of_item(node: ast.Tuple) -> Iterator[str]:
    """Name and description of an item of an enumeration: (IDENTIFIER, "Name", "Description", …)."""
    if len(node.elts) < 3:
        return
    identifier, *texts = node.elts[:3]
    named = isinstance(identifier, (ast.Name, ast.Attribute)) or any(text.isupper() for text in constants(identifier))
    if named and all(isinstance(text, ast.Constant) and isinstance(text.value, str) for text in texts):
        for text in texts:
            yield from constants(text)


def spoken(tree: ast.Module) -> Iterator[str]:
    """Constants that a module assigns or returns."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.Assign, ast.Return)) and node.value is not None:
            yield from constants(node.value)


def constants(node: ast.expr) -> Iterator[str]:
    """The string that an expression is, or the two that it chooses from."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from constants(node.body)
        yield from constants(node.orelse)


if __name__ == "__main__":
    sys.exit(main())
