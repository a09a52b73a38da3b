# SPDX-License-Identifier: GPL-3.0-or-later
"""What a refusal of bad input must look like."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

import isochor
import pytest


@contextmanager
def refused(kind: type[isochor.Error], *said: object) -> Iterator[pytest.ExceptionInfo[isochor.Error]]:
    """The block must raise `kind`, as a ValueError, in a sentence that holds every word and number of `said`.

    Words count in any case and inside longer ones ("axes" in "of axes,"); numbers only as whole numbers.
    A tuple is a choice: one of its members must be there.
    """
    with pytest.raises(isochor.Error) as caught:
        yield caught
    error, message = caught.value, str(caught.value)
    assert isinstance(error, kind), f"{type(error).__name__} instead of {kind.__name__}: {message}"
    assert isinstance(error, ValueError), f"{type(error).__name__} is not a ValueError: {message}"
    assert len(message) > 20, f"too short to help: {message!r}"
    assert "panic" not in message.lower()
    for item in said:
        choices = item if isinstance(item, tuple) else (item,)
        assert any(_holds(message, choice) for choice in choices), f"{item!r} is not said in: {message!r}"


def _holds(message: str, item: object) -> bool:
    if isinstance(item, int):
        return re.search(rf"(?<![\d.]){item}(?![\d]|\.\d)", message.replace(",", "").replace("_", "")) is not None
    return str(item).lower() in message.lower()
