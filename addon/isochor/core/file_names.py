# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of files made from names of objects: safe on every system, and different for different objects."""

import hashlib
import re

_UNSAFE = re.compile(r"[^\w .()+=@,-]|[\x00-\x1f]")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_LONGEST = 120
"""Letters of a name, at most; a letter takes up to four of the 255 bytes that file systems allow."""
_LONGEST_BYTES = 180


def safe_name(name: str) -> str:
    """The name where every system takes it as a file's; else what is left of it and a mark that tells it from others
    that leave the same."""
    plain = _UNSAFE.sub("_", name)[:_LONGEST].strip(" .")
    while len(plain.encode()) > _LONGEST_BYTES:
        plain = plain[:-1]
    if plain == name and not _RESERVED.fullmatch(name):
        return name
    return f"{plain}_{mark(name)}"


def mark(name: str) -> str:
    """Eight letters that follow from the name."""
    return hashlib.sha256(name.encode("utf-8", "surrogateescape")).hexdigest()[:8]


def unique_names(names: list[str]) -> list[str]:
    """A safe name for each of these different names, no two the same even where the file system ignores case."""
    safe = [safe_name(name) for name in names]
    folded = [name.casefold() for name in safe]
    return [
        f"{plain}_{mark(name)}" if folded.count(plain.casefold()) > 1 else plain
        for name, plain in zip(names, safe, strict=True)
    ]
