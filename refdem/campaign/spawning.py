"""How worker processes are started: afresh, with locks that are pipes.

Python's own locks between processes are files in /dev/shm, which all of these processes map. Any
program may truncate them, and that ends the processes by SIGBUS. They are also known to a process
of Python's, its resource tracker, by name; one that was killed and started again does not know
them, and says so by a traceback. A pipe has no name, and nothing of it is mapped.
"""

import os
import threading
import time
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext

BYTE = b"-"
"""What lies in the pipe of a lock that nobody holds."""
LONGEST_POLL = 1e6
"""Seconds for which a pipe is polled at once; poll(2) counts milliseconds in 31 bits."""


class PipeLock:
    """A lock between processes: whoever has taken the one byte out of a pipe holds it.

    It has those methods of `multiprocessing.RLock` that the pool of workers calls. Its holder, a
    thread, may acquire it once more, and releases it as often as it was acquired.
    """

    def __init__(self, context: SpawnContext) -> None:
        """Makes the pipe; a process that is started by the context may be given this lock."""
        self._taken_from, self._put_into = context.Pipe(duplex=False)
        # Another process may take the byte between the look at the pipe and the read.
        os.set_blocking(self._taken_from.fileno(), False)
        os.write(self._put_into.fileno(), BYTE)
        self._holder: int | None = None
        self._times = 0

    def __getstate__(self) -> tuple[Connection, Connection]:
        """Another process gets the pipe; it does not hold the lock."""
        return self._taken_from, self._put_into

    def __setstate__(self, state: tuple[Connection, Connection]) -> None:
        self._taken_from, self._put_into = state
        self._holder = None
        self._times = 0

    def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
        """Whether the lock was acquired, within `timeout` [s] if that is given, at once if it is
        not to `block`.
        """
        if not block:
            timeout = 0.0
        if timeout is None:
            timeout = float("inf")
        thread = threading.get_ident()
        if self._holder != thread and not self._comes(time.monotonic() + timeout):
            return False
        self._holder = thread
        self._times += 1
        return True

    def release(self) -> None:
        """Takes one acquisition back; after the last one another thread or process may hold it."""
        self._times -= 1
        if self._times == 0:
            self._holder = None
            os.write(self._put_into.fileno(), BYTE)

    def _comes(self, end: float) -> bool:
        """Whether the byte is taken before `end` [s] of the monotonic clock."""
        while True:
            left = max(0.0, end - time.monotonic())
            is_there = self._taken_from.poll(min(left, LONGEST_POLL))
            if is_there and self._takes():
                return True
            if not is_there and left <= LONGEST_POLL:
                return False

    def _takes(self) -> bool:
        """Whether the byte was still there, and is taken now."""
        try:
            return bool(os.read(self._taken_from.fileno(), 1))
        except BlockingIOError:
            return False


class Spawning(SpawnContext):
    """Starts processes afresh, so that no state is shared, and makes locks of pipes."""

    def RLock(self) -> PipeLock:  # type: ignore[override]  # noqa: N802 - the name that is called
        """A lock that the processes of this context share."""
        return PipeLock(self)
