# SPDX-License-Identifier: GPL-3.0-or-later
"""What the test legs report: how many tests passed, failed and were skipped, read from each runner's own words."""

import re
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workspace import ROOT, environment

CARGO_LINE = re.compile(r"^test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", re.MULTILINE)


@dataclass(frozen=True)
class Report:
    """The outcome of one leg; `note` says in a few words what stands behind the numbers."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    note: str = ""

    def __add__(self, other: "Report") -> "Report":
        return Report(self.passed + other.passed, self.failed + other.failed, self.skipped + other.skipped)


def from_status(status: int, what: str) -> Report:
    """One check that passes or fails as a whole."""
    return Report(1, 0, note=what) if status == 0 else Report(0, 1, note=f"{what}: exit status {status}")


def from_cargo(status: int, text: str) -> Report:
    """The sums over the closing lines of `cargo test`; a status without a failed test (a crash) counts as one."""
    counts = [tuple(int(number) for number in found) for found in CARGO_LINE.findall(text)]
    passed, failed, ignored = (sum(column) for column in zip(*counts, strict=True)) if counts else (0, 0, 0)
    return _judged(status, Report(passed, failed, ignored))


def from_junit(status: int, place: Path) -> Report:
    """The sums of pytest's XML report; a missing report or a status without a failed test counts as a failure."""
    if not place.is_file():
        return Report(0, 1, note=f"no test report was written (exit status {status})")
    suites = list(ElementTree.parse(place).getroot().iter("testsuite"))
    total, failed, errors, skipped = (
        sum(int(suite.get(name, "0")) for suite in suites) for name in ("tests", "failures", "errors", "skipped")
    )
    return _judged(status, Report(total - failed - errors - skipped, failed + errors, skipped))


def echoed(command: list[str], env: Mapping[str, str], limit_s: float) -> tuple[int, str]:
    """Runs the command, shows its output as it comes, and returns its exit status and output; ends it at the limit."""
    with subprocess.Popen(
        command, cwd=ROOT, env=environment(env), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL, text=True, errors="replace",
    ) as process:  # fmt: skip
        timer = threading.Timer(limit_s, process.kill)
        timer.start()
        lines = []
        for line in process.stdout or ():
            sys.stdout.write(line)
            sys.stdout.flush()
            lines.append(line)
        status = process.wait()
        overdue = not timer.is_alive()
        timer.cancel()
    if overdue and status != 0:
        print(f"isochor: ended after {limit_s:.0f} s: {' '.join(command)}", flush=True)
    return status, "".join(lines)


def _judged(status: int, report: Report) -> Report:
    if status != 0 and report.failed == 0:
        return Report(report.passed, 1, report.skipped, f"the runner ended with status {status}")
    if report.passed + report.failed == 0:
        return Report(0, 1, report.skipped, "no test was run")
    return report
