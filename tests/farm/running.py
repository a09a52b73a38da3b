# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tasks of a farm job on this machine: several at a time, each when all that it depends on is done."""

import subprocess
import threading
import time
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field

# One task takes seconds; on a busy machine, tens of them.
LIMIT_S = 300.0


@dataclass(frozen=True)
class Task:
    """Commands to run one after another, and the places in the job of the tasks that must be done before."""

    name: str
    commands: list[list[str]]
    dependencies: tuple[int, ...]


@dataclass
class Run:
    """What became of each task by name: its exit status (None: not run) and output; and how many ran at once."""

    status: dict[str, int | None] = field(default_factory=dict)
    output: dict[str, str] = field(default_factory=dict)
    order: list[str] = field(default_factory=list)
    most_at_once: int = 0

    def failed(self) -> list[str]:
        return [name for name, status in self.status.items() if status]


def run_all(tasks: Sequence[Task], workers: int = 2) -> Run:
    """Runs the job as a farm would; a task whose dependency failed is not run."""
    run = Run({task.name: None for task in tasks})
    waiting, running = dict(enumerate(tasks)), {}
    counter = _Counter(run)
    with ThreadPoolExecutor(workers) as pool:
        while True:
            ready = [i for i, task in waiting.items() if all(_is_done(run, tasks[j]) for j in task.dependencies)]
            running |= {pool.submit(_run, waiting.pop(i), run, counter): i for i in ready}
            if not running:
                return run
            done: set[Future[None]] = wait(running, return_when=FIRST_COMPLETED).done
            for future in done:
                running.pop(future)
                future.result()


def _is_done(run: Run, task: Task) -> bool:
    return run.status[task.name] == 0


def _run(task: Task, run: Run, counter: "_Counter") -> None:
    with counter:
        run.order.append(task.name)
        status, output = 0, []
        for command in task.commands:
            status, text = ran(command)
            output.append(text)
            if status:
                break
        run.output[task.name], run.status[task.name] = "".join(output), status


def ran(command: Sequence[str], env: dict[str, str] | None = None) -> tuple[int, str]:
    """Exit status and output of one command."""
    start = time.monotonic()
    done = subprocess.run(
        command, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LIMIT_S, env=env
    )
    print(f"$ {command}\n{done.stdout}status {done.returncode} after {time.monotonic() - start:.1f} s", flush=True)
    return done.returncode, done.stdout


class _Counter:
    """Counts the tasks that run at the same time."""

    def __init__(self, run: Run) -> None:
        self._run, self._lock, self._now = run, threading.Lock(), 0

    def __enter__(self) -> None:
        with self._lock:
            self._now += 1
            self._run.most_at_once = max(self._run.most_at_once, self._now)

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._now -= 1
