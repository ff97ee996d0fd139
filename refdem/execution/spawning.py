"""How worker processes are started: by spawning, protected from interrupts, with locks that are
released when their holder ends.

Python's own locks between processes are files in /dev/shm, which all of these processes map. Any
program may truncate them, which ends the processes by SIGBUS. They are also registered by name with
Python's resource tracker. If that process is killed and restarted, it does not know them and prints
a traceback. A lock whose holder is killed stays locked for ever. A record lock on a pipe, see
fcntl(2), has no name and no mapped memory, and the system releases it when its holder ends.
"""

import fcntl
import signal
import threading
import time
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from typing import Any

INTERRUPT = (signal.SIGINT,)
PAUSE = 0.001
"""Seconds between attempts to get a lock that another process holds: a worker holds it while it
reads a job or writes a result.
"""


class PipeLock:
    """A lock between processes: the process with a record lock on the pipe holds it.

    It has those methods of `multiprocessing.RLock` that the pool of workers calls. The thread that
    holds it may acquire it again, and must release it as often as it acquired it.
    """

    def __init__(self, context: SpawnContext) -> None:
        """Makes the pipe; a process that is started by the context may be given this lock."""
        # No data is sent through the pipe. Only its writable end can be locked exclusively.
        unused, end = context.Pipe(duplex=False)
        unused.close()
        self.__setstate__(end)

    def __getstate__(self) -> Connection:
        """The pipe, which is sent to another process; that process does not hold the lock."""
        return self._end

    def __setstate__(self, end: Connection) -> None:
        self._end = end
        # A record lock is held by a process; this lock excludes its threads from one another.
        self._of_threads = threading.RLock()
        self._times = 0

    def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
        """True if the lock was acquired: within `timeout` [s] if given, at once if not `block`."""
        if not block:
            timeout = 0.0
        if timeout is None:
            timeout = float("inf")
        end = time.monotonic() + timeout
        if not self._of_threads.acquire(timeout=min(timeout, threading.TIMEOUT_MAX)):
            return False
        if self._times == 0 and not self._is_got_before(end):
            self._of_threads.release()
            return False
        self._times += 1
        return True

    def release(self) -> None:
        """Undoes one acquisition; after the last one another thread or process may acquire it."""
        self._times -= 1
        if self._times == 0:
            fcntl.lockf(self._end.fileno(), fcntl.LOCK_UN)
        self._of_threads.release()

    def _is_got_before(self, end: float) -> bool:
        """True if this process gets the record lock before `end` [s] of the monotonic clock."""
        while not self._is_got():
            if time.monotonic() >= end:
                return False
            time.sleep(PAUSE)
        return True

    def _is_got(self) -> bool:
        """True if this process gets the record lock now."""
        try:
            fcntl.lockf(self._end.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            # Another process holds it: systems report this by one of these errors.
            return False
        return True


class SpawnedProcess(SpawnProcess):
    """A process that an interrupt does not reach while it starts.

    A terminal interrupts all processes of a command. A process that is still importing its modules
    would end with a traceback, before it could leave interrupts to its parent.
    """

    @staticmethod
    def _Popen(process_obj: BaseProcess) -> Any:  # noqa: N802 - the name that is called
        """Starts the process with interrupts blocked, which it inherits; `unblock_interrupts` is
        its own to call.
        """
        before = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPT)
        try:
            return SpawnProcess._Popen(process_obj)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def unblock_interrupts() -> None:
    """Lets interrupts reach this process, and those that it starts, as the system delivers them."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, INTERRUPT)


class Spawning(SpawnContext):
    """Starts processes afresh, so that no state is shared, and makes locks of pipes."""

    Process = SpawnedProcess

    def RLock(self) -> PipeLock:  # type: ignore[override]  # noqa: N802 - the name that is called
        """A lock that the processes of this context share."""
        return PipeLock(self)
