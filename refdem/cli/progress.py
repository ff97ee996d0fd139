"""Progress: one line that is redrawn on a terminal, a plain line a stage in a pipe."""

import sys
import time


class Progress:
    """Called with stage, done, total; writes to stderr so that output can be piped."""

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
            print(f"\r\x1b[K{stage}: {done}/{total}", end=end, file=sys.stderr, flush=True)
        elif not self._tty and done == total:
            print(f"{stage}: {total} done, {now - self._start:.1f} s", file=sys.stderr, flush=True)
