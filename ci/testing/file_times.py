"""A plugin of pytest that tells the files of tests on which processors worked longest.

Seconds of CPU, of the tests and of all processes that they waited for: on a busy machine these stay
what they are. tests/conftest.py registers it; it tells where `--durations` asks for times.
"""

import resource
import time
from collections import defaultdict
from collections.abc import Generator
from typing import Any

import pytest

MOST = 20
"""Largest number of files that are reported."""
COLLECTED = "(start and collection, in each process)"


def seconds_used() -> float:
    """Seconds of CPU that this process, and those that it waited for, have used so far."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


class FileTimes:
    """Seconds of CPU by file, of this process and, under xdist, of all workers."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def pytest_collection_finish(self) -> None:
        """Everything until now was the start, and the collection."""
        self.seconds[COLLECTED] += seconds_used()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Counts the seconds of one test, with its fixtures, for its file."""
        begun = seconds_used()
        try:
            return (yield)
        finally:
            file, _, _ = item.nodeid.partition("::")
            self.seconds[file] += seconds_used() - begun

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A worker of xdist hands its seconds to the process that tells them."""
        output = getattr(session.config, "workeroutput", None)
        if output is not None:
            output["file_times"] = dict(self.seconds)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Adds what a worker has counted; one that crashed has handed nothing on."""
        output = getattr(node, "workeroutput", None) or {}
        for file, seconds in output.get("file_times", {}).items():
            self.seconds[file] += seconds

    def pytest_terminal_summary(self, terminalreporter: Any, config: pytest.Config) -> None:
        """The files, the longest first, and the sum of all."""
        if config.getoption("durations") is None or not self.seconds:
            return
        terminalreporter.section(f"seconds of CPU by file, the {MOST} longest")
        longest_first = sorted(self.seconds.items(), key=lambda row: row[1], reverse=True)
        for file, seconds in longest_first[:MOST]:
            terminalreporter.write_line(f"{seconds:8.1f}  {file}")
        total = sum(self.seconds.values())
        terminalreporter.write_line(f"{total:8.1f}  in all")
