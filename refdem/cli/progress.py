"""Progress on stderr, so that output can be piped: one line that is redrawn on a terminal, and
plain lines in a pipe.
"""

import sys
import threading
import time
from contextlib import suppress
from types import TracebackType
from typing import Self

ERASE = "\r\x1b[K"
"""Control characters by which the next text replaces the current line of a terminal."""
QUIET = 3.0
"""CPU seconds without output after which work reports that it continues."""
LOOK = 0.5
"""Seconds between checks of the progress of work."""

DAY = 86400.0
"""Seconds of a day."""


def rounded(seconds: float) -> str:
    """A time in the unit that fits it."""
    if seconds > DAY:
        return f"{seconds / DAY:.2g} days"
    return f"{seconds:.0f} s"


class Progress:
    """Called with stage, done, total: with none done when the stage begins, then after each job."""

    def __init__(self) -> None:
        self._tty = sys.stderr.isatty()
        self._last = 0.0
        self._start = time.perf_counter()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Shows that `done` of `total` jobs of a stage have ended."""
        now = time.perf_counter()
        if self._tty and (now - self._last > 0.1 or done == total):
            self._last = now
            if done < total:
                end = ""
            else:
                end = "\n"
            _show(f"{ERASE}{stage}: {done}/{total}{end}")
        elif not self._tty and done == 0:
            _show(f"{stage}: {total} to do\n")
        elif not self._tty and done == total:
            _show(f"{stage}: {total} done, {now - self._start:.1f} s\n")


def _show(text: str) -> None:
    """Writes to standard error; a failure to do so is ignored."""
    with suppress(OSError, ValueError):
        print(text, end="", file=sys.stderr, flush=True)


class Watch:
    """Reports that work in this process continues: after `quiet` CPU seconds, and in a pipe
    whenever that time has doubled.

    A separate thread reports, so that the work itself need not do so. `expect` sets the remaining
    CPU seconds, where they are known.
    """

    def __init__(self, work: str, quiet: float = QUIET) -> None:
        self._work = work
        self._next = quiet
        self._tty = sys.stderr.isatty()
        self._begun = time.process_time()
        self._whole: float | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._refresh, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join()
        if self._tty:
            _show(ERASE)

    def expect(self, seconds: float) -> None:
        """Sets the expected remaining CPU seconds."""
        self._whole = self._elapsed() + seconds

    def say(self, text: str) -> None:
        """Prints a text in a line of its own, above the line that is redrawn."""
        start = ""
        if self._tty:
            start = ERASE
        _show(f"{start}{text}\n")

    def _elapsed(self) -> float:
        """CPU seconds since the start."""
        return time.process_time() - self._begun

    def _refresh(self) -> None:
        """Reports at intervals until the work has ended."""
        while not self._ended.wait(LOOK):
            spent = self._elapsed()
            if spent < self._next:
                continue
            line = f"{self._work}: {spent:.0f} s of CPU so far"
            if self._whole is not None and self._whole > spent:
                line += f", about {rounded(self._whole - spent)} to go"
            if self._tty:
                # The line is drawn again in its place.
                line = ERASE + line
            else:
                # A file gets few lines, each at twice the time of the one before.
                line += "\n"
                self._next = 2 * spent
            _show(line)
