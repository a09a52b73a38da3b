# SPDX-License-Identifier: GPL-3.0-or-later
"""A leg that failed, crashed or ran nothing must never read as one that passed."""

import pytest
from reports import Report, echoed, from_cargo, from_junit, from_status

PASSED = "test result: ok. 7 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s\n"
FAILED = "test result: FAILED. 2 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s\n"


def junit(tmp_path, **counts):
    place = tmp_path / "report.xml"
    words = " ".join(f'{name}="{count}"' for name, count in counts.items())
    place.write_text(f"<testsuites><testsuite {words}/></testsuites>")
    return place


def numbers(report):
    return report.passed, report.failed, report.skipped


def test_cargo_sums_over_its_test_binaries():
    assert numbers(from_cargo(101, PASSED + FAILED)) == (9, 3, 1)


def test_cargo_that_does_not_compile_has_failed():
    assert from_cargo(101, "error: could not compile").failed == 1


def test_cargo_that_crashes_after_good_tests_has_failed():
    assert numbers(from_cargo(101, PASSED)) == (7, 1, 1)


def test_cargo_without_tests_has_failed():
    assert from_cargo(0, PASSED.replace("7 passed", "0 passed")).failed == 1


def test_junit_counts_errors_as_failures(tmp_path):
    place = junit(tmp_path, tests=10, failures=2, errors=1, skipped=3)
    assert numbers(from_junit(1, place)) == (4, 3, 3)


def test_a_missing_report_has_failed(tmp_path):
    assert from_junit(0, tmp_path / "report.xml").failed == 1


def test_a_runner_that_crashes_after_its_report_has_failed(tmp_path):
    assert from_junit(-11, junit(tmp_path, tests=5, failures=0, errors=0, skipped=0)).failed == 1


def test_only_skipped_tests_have_failed(tmp_path):
    assert from_junit(0, junit(tmp_path, tests=5, failures=0, errors=0, skipped=5)).failed == 1


@pytest.mark.parametrize(("status", "expected"), [(0, (1, 0, 0)), (1, (0, 1, 0)), (-9, (0, 1, 0))])
def test_a_check_passes_or_fails_as_a_whole(status, expected):
    assert numbers(from_status(status, "check")) == expected


def test_reports_add_up():
    assert Report(1, 2, 3) + Report(10, 20, 30) == Report(11, 22, 33)


def test_a_hung_runner_is_ended(capfd):
    status, _ = echoed(["sleep", "60"], {}, limit_s=0.2)
    assert status != 0
    assert "ended after" in capfd.readouterr().out


def test_output_is_shown_and_returned(capfd):
    status, text = echoed(["printf", "one\ntwo\n"], {}, limit_s=10)
    assert (status, text) == (0, "one\ntwo\n")
    assert capfd.readouterr().out == text
