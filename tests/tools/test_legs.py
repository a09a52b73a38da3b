# SPDX-License-Identifier: GPL-3.0-or-later
"""Words for pytest stand in the place of all tests of a leg, and nowhere else."""

import legs
import pytest
import run_tests
from reports import Report

WORDS = ["tests/tools/test_build.py", "-k", "stub"]


@pytest.fixture
def commands(monkeypatch):
    found = []
    monkeypatch.setattr(legs, "_pytest", lambda command, *_rest: found.append(command) or Report(passed=1))
    return found


def run(name, words):
    next(leg for leg in legs.all_legs(words) if leg.name == name).run()


def test_a_leg_runs_all_its_tests(commands):
    run("tools", ())
    assert commands[0][-1] == str(legs.TESTS / "tools")


def test_a_leg_runs_the_tests_that_are_named(commands):
    run("tools", WORDS)
    assert commands[0][-3:] == WORDS
    assert str(legs.TESTS / "tools") not in commands[0]


def test_tests_without_a_leg_are_refused(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["run_tests.py", "--tests", "tests/tools/test_build.py"])
    with pytest.raises(SystemExit):
        run_tests.main()
    assert "--only" in capsys.readouterr().err
