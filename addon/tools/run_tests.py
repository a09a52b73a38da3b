# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs every test there is, leg by leg, and ends with a table and the totals; status 1 on any failure.

Use: python run_tests.py [--only LEG ... [--tests "FILE -k NAME"]]. A leg that this machine cannot run is a failure
where CI=true and a loud SKIPPED elsewhere. --tests gives pytest other words than all tests of the leg.
"""

import argparse
import shlex
import subprocess
import time

from legs import Leg, all_legs
from reports import Report
from workspace import Unavailable, in_ci

WIDTH = 100


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [leg.name for leg in all_legs()]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="LEG", help=", ".join(names))
    parser.add_argument("--tests", type=shlex.split, default=[], metavar="WORDS", help="files, and options of pytest")
    chosen = parser.parse_args()
    if chosen.tests and chosen.only == names:
        parser.error("--tests needs --only: say in which leg those tests are")
    results = [_timed(leg) for leg in all_legs(chosen.tests) if leg.name in chosen.only]
    return _summary(results)


def _timed(leg: Leg) -> tuple[Leg, Report, float]:
    print(f"\n{f' {leg.name}: {leg.title} ':=^{WIDTH}}", flush=True)
    start = time.monotonic()
    report = _outcome(leg)
    return leg, report, time.monotonic() - start


def _outcome(leg: Leg) -> Report:
    try:
        return leg.run()
    except Unavailable as reason:
        if in_ci():
            print(f"FAILED, this leg must run in CI: {reason}", flush=True)
            return Report(failed=1, note=f"cannot run: {reason}")
        print(f"{'':!^{WIDTH}}\nSKIPPED, NOT TESTED: {leg.title}\n{reason}\n{'':!^{WIDTH}}", flush=True)
        return Report(skipped=1, note=f"SKIPPED: {reason}")
    except subprocess.CalledProcessError as error:
        print(f"FAILED: {error}", flush=True)
        return Report(failed=1, note="a command before the tests failed: see above")


def _summary(results: list[tuple[Leg, Report, float]]) -> int:
    print(f"\n{' all legs ':=^{WIDTH}}")
    print(f"{'leg':<10}{'passed':>8}{'failed':>8}{'skipped':>9}{'seconds':>9}  note")
    total = Report()
    for leg, report, seconds in results:
        counts = f"{report.passed:>8}{report.failed:>8}{report.skipped:>9}{seconds:>9.1f}"
        print(f"{leg.name:<10}{counts}  {report.note}")
        total += report
    skipped = f", {total.skipped} skipped" if total.skipped else ""
    print(f"\n{total.passed} passed, {total.failed} failed{skipped}", flush=True)
    return 1 if total.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
