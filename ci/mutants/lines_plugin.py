"""For pytest: what lines of Python and of C each test runs, and how long it takes.

`pytest -p lines_plugin` with ci/mutants on the path. REFDEM_LINES is an empty folder; for test
number n it gets n/ with the counters of the kernels (gcov), and at the end tests.json with names,
seconds and lines of Python. Tests that fail have no entry.
"""

import ctypes
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest

OUT = Path(os.environ["REFDEM_LINES"])
ROOT = Path(os.environ["REFDEM_LINES_OF"])
MEASURED = [str(ROOT / "refdem" / part / "*") for part in ("checks", "core", "engines", "solvers")]

_coverage = coverage.Coverage(data_file=None, include=MEASURED, config_file=False, messages=False)
_coverage.set_option("run:disable_warnings", ["no-data-collected", "couldnt-parse"])
_seconds: dict[str, float] = {}
_failed: set[str] = set()


def pytest_sessionstart() -> None:
    """Python is followed before anything of refdem is imported by a test."""
    _coverage.start()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """One test: its context, its counters and its seconds."""
    number = len(_seconds)
    forget_kernels()
    os.environ["GCOV_PREFIX"] = str(OUT / str(number))
    os.environ["GCOV_PREFIX_STRIP"] = "99"
    _coverage.switch_context(item.nodeid)
    begun = time.perf_counter()
    try:
        return (yield)
    finally:
        _seconds[item.nodeid] = time.perf_counter() - begun
        keep_kernels()
        _coverage.switch_context("")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """What fails without any error planted has no say on errors that are."""
    if report.failed:
        _failed.add(report.nodeid)


def pytest_sessionfinish() -> None:
    """Writes tests.json."""
    _coverage.stop()
    data = _coverage.get_data()
    lines: dict[str, dict[str, list[int]]] = {}
    for file in data.measured_files():
        for line, names in data.contexts_by_lineno(file).items():
            for name in filter(None, names):
                here = lines.setdefault(name, {})
                here.setdefault(str(Path(file).relative_to(ROOT)), []).append(line)
    tests = [
        {"name": name, "seconds": seconds, "failed": name in _failed, "lines": lines.get(name, {})}
        for name, seconds in _seconds.items()
    ]
    (OUT / "tests.json").write_text(json.dumps(tests))


def kernels() -> list[ctypes.CDLL]:
    """The instrumented kernels that are loaded now."""
    found = []
    for name, module in list(sys.modules.items()):
        path = getattr(module, "__file__", None)
        if name.startswith("refdem.kernels._") and path and path.endswith(".so"):
            found.append(ctypes.CDLL(path))
    return found


def forget_kernels() -> None:
    """Sets all counters of kernels to zero."""
    for kernel in kernels():
        kernel.refdem_forget_lines()


def keep_kernels() -> None:
    """Writes the counters of kernels to GCOV_PREFIX."""
    for kernel in kernels():
        kernel.refdem_keep_lines()
