"""Seconds of CPU by file: those of tests, of processes that they waited for, and of all workers."""

import subprocess
import sys
from types import SimpleNamespace

import pytest
from file_times import COLLECTED, FileTimes, seconds_used


class Told:
    """What is printed at the end."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def section(self, title: str) -> None:
        """A line of its own."""
        self.lines.append(title)

    def write_line(self, line: str) -> None:
        """The next line."""
        self.lines.append(line)


def asked(durations: int | None) -> SimpleNamespace:
    """The settings of a session."""
    return SimpleNamespace(getoption=lambda name: durations)


def test_processes_that_were_waited_for_count() -> None:
    before = seconds_used()
    subprocess.run([sys.executable, "-c", "sum(range(2_000_000))"], check=True)
    alone = seconds_used() - before
    assert alone > 0
    assert seconds_used() >= before + alone


def test_seconds_of_workers_are_added_and_the_longest_come_first() -> None:
    times = FileTimes()
    for worker in ({"a.py": 1.0, "b.py": 2.5}, {"a.py": 3.0, COLLECTED: 0.5}, None):
        output = None if worker is None else {"file_times": worker}
        times.pytest_testnodedown(SimpleNamespace(workeroutput=output))
    told = Told()
    times.pytest_terminal_summary(told, asked(25))
    assert told.lines[1:] == [
        "     4.0  a.py",
        "     2.5  b.py",
        f"     0.5  {COLLECTED}",
        "     7.0  in all",
    ]


def test_nothing_is_told_where_nobody_asks_for_times() -> None:
    times = FileTimes()
    times.seconds["a.py"] = 1.0
    told = Told()
    times.pytest_terminal_summary(told, asked(None))
    assert told.lines == []


def test_this_test_is_counted_for_its_file(request: pytest.FixtureRequest) -> None:
    times = request.config.pluginmanager.get_plugin("file-times")
    counting = times.pytest_runtest_protocol(request.node)
    next(counting)
    before = times.seconds["tests/ci/testing/test_file_times.py"]
    sum(range(1_000_000))
    with pytest.raises(StopIteration):
        next(counting)
    assert times.seconds["tests/ci/testing/test_file_times.py"] > before
